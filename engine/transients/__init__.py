"""Runs under a load that is no harmonic: pulses, sweeps and records; their peaks, their parts, shock response."""
