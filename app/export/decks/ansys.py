"""A deck for Ansys Mechanical APDL: MASS21, COMBIN14, and COMBIN40 as contact. Not run by this project.

Source: Ansys Mechanical APDL Element Reference. The spring and the damper of COMBIN40 are parallel, and in series with
a gap: they act where the distance of its nodes has shrunk by the gap, which must not be zero.
"""

from vibroscope.app.export.decks.problem import LINEAR, DeckProblem, check

NAME, SUFFIX, STATUS = "Ansys Mechanical APDL", "dat", "end"
LAWS = (LINEAR,)
INTEGRATORS = {
    "newmark": lambda i: f"TRNOPT,FULL\nTINTP,,{i.beta!r},{i.gamma!r}",
    "hht": lambda i: (
        f"TRNOPT,FULL,,,,,HHT\nTINTP,,{(1.0 - i.alpha) ** 2 / 4.0!r},{0.5 - i.alpha!r},,,,,,,{-i.alpha!r},0"
    ),
}
_TOUCHING = 1e-12  # units of length: the element takes a gap of zero for none

_DECK = """\
! {words}
! Not run by Vibroscope, which has no licence of this code: look at the first results before you trust them.
!
! Run it with: ansys -b -i {name}.dat. It writes {name}.csv itself; then
!   {compare}
!
! The contact status is iterated until it agrees with the end of the step.
/PREP7
ET,1,MASS21,,,4          ! mass in the plane, no rotation
ET,2,COMBIN14,,1         ! spring and damper along x
ET,3,COMBIN40,,,1        ! spring, damper and gap along x
N,1,0
N,2,0
N,3,0
N,4,0
{bodies}
R,30,{stiffness!r},{damping!r},0,{gap!r}
TYPE,3
REAL,30
E,2,3
{second}D,1,ALL,0
D,4,ALL,0
D,2,UY,0
D,3,UY,0
{wall}FINISH
/SOLU
ANTYPE,TRANS
{integrator}
NLGEOM,OFF
NROPT,FULL
{start}CNVTOL,F,,1E-10,,1E-12
*DIM,LOAD1,TABLE,{steps}+1,,,TIME
*DIM,LOAD2,TABLE,{steps}+1,,,TIME
*DO,K,0,{steps}
  LOAD1(K+1,0)=K*{step!r}
  LOAD2(K+1,0)=K*{step!r}
  A=2*ACOS(-1)*MOD(K,{n})/{n}
  LOAD1(K+1,1)={load1}
  LOAD2(K+1,1)={load2}
*ENDDO
F,2,FX,%LOAD1%
F,3,FX,%LOAD2%
AUTOTS,OFF
KBC,0
DELTIM,{step!r}
OUTRES,ALL,NONE
OUTRES,NSOL,{every}
TIME,{end!r}
SOLVE
FINISH
/POST26
NUMVAR,200
NSOL,2,2,U,X
NSOL,3,3,U,X
*GET,ROWS,VARI,,NSETS
*DEL,T
*DEL,X1
*DEL,X2
*DIM,T,ARRAY,ROWS
*DIM,X1,ARRAY,ROWS
*DIM,X2,ARRAY,ROWS
VGET,T(1),1
VGET,X1(1),2
VGET,X2(1),3
*VOPER,X1(1),X1(1),ADD,{x1!r}
*VOPER,X2(1),X2(1),ADD,{x2!r}
*CFOPEN,{name},csv
*VWRITE,'{head1}','{head2}','{head3}'
(A8,',',A8,',',A8)
*DIM,KEPT,ARRAY,ROWS
*DO,K,1,ROWS
  KEPT(K)=T(K)-({first!r})
*ENDDO
*VMASK,KEPT(1)
*VWRITE,T(1),X1(1),X2(1)
(E24.16,',',E24.16,',',E24.16)
*CFCLOS
FINISH
"""


def write(problem: DeckProblem) -> str:
    """The deck; raises ValueError for what Ansys has not."""
    check(problem, NAME, LAWS, tuple(INTEGRATORS), STATUS)
    stiffness, damping = problem.contact
    gap, parts = problem.gap(), problem.parts(NAME, STATUS, SUFFIX, "! ")
    head1, head2, head3 = parts["header"].replace(" [", "[").split(", ")
    loads = [*(_load(body) for body in problem.bodies), "0"]
    return _DECK.format(
        **parts,
        bodies="\n".join(_bodies(problem)),
        stiffness=stiffness,
        damping=damping,
        gap=gap or _TOUCHING * problem.length,
        second=_second_stop(problem),
        wall="D,3,UX,0\n" if problem.system.wall else "",
        integrator=INTEGRATORS[problem.integrator.name](problem.integrator),
        start=_start(problem),
        steps=problem.steps,
        n=problem.method.steps,
        load1=loads[0],
        load2=loads[1],
        head1=head1,
        head2=head2,
        head3=head3,
    )


def _second_stop(problem: DeckProblem) -> str:
    """A contact whose nodes are exchanged: it acts where their distance has grown."""
    if not problem.system.two_stops:
        return ""
    stiffness, damping = problem.second_contact
    gap = problem.second_gap() or _TOUCHING * problem.length
    return f"R,31,{stiffness!r},{damping!r},0,{gap!r}\nREAL,31\nE,3,2\n"


def _load(body) -> str:
    """The force at the angle A; the spring's at the start is taken off, since displacements are counted from there."""
    cosine, sine, rest = body.load_from_start
    return f"({cosine!r})*COS(A)+({sine!r})*SIN(A)+({rest!r})"


def _bodies(problem: DeckProblem) -> list[str]:
    lines = []
    for i, body in enumerate(problem.bodies, 1):
        ends = "1,2" if i == 1 else "3,4"
        lines += [f"R,{i},{body.mass!r}", "TYPE,1", f"REAL,{i}", f"E,{i + 1}"]
        lines += [f"R,{10 + i},{body.stiffness!r},{body.damping!r}", "TYPE,2", f"REAL,{10 + i}", f"E,{ends}"]
    return lines


def _start(problem: DeckProblem) -> str:
    rows = [f"IC,{node},UX,0,{body.velocity!r}" for node, body in enumerate(problem.bodies, 2) if body.velocity]
    return "\n".join([*rows, ""]) if rows else ""
