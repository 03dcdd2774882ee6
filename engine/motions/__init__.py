"""What moves: kind of motion, period, multipliers, Lyapunov exponent, coexisting motions."""
