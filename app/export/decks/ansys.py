"""A deck for Ansys Mechanical APDL: MASS21, COMBIN14, and COMBIN40 as contact. Not run by this project.

Source: Ansys Mechanical APDL Element Reference. The spring and the damper of COMBIN40 are parallel, and in series with
a gap: they act where the distance of its nodes has shrunk by the gap, which must not be zero.
"""

from vibroscope.app.export.decks.problem import LINEAR, DeckProblem

NAME, SUFFIX, STATUS, COMMENT = "Ansys Mechanical APDL", "dat", "end", "! "
LAWS = (LINEAR,)
INTEGRATORS = {
    "newmark": lambda i: f"TRNOPT,FULL\nTINTP,,{i.beta!r},{i.gamma!r}",
    "hht": lambda i: (
        f"TRNOPT,FULL,,,,,HHT\nTINTP,,{(1.0 - i.alpha) ** 2 / 4.0!r},{0.5 - i.alpha!r},,,,,,,{-i.alpha!r},0"
    ),
}
_TOUCHING = 1e-12  # units of length: the element takes a gap of zero for none

TEMPLATE = """\
! {words}
! Not run by Vibroscope, which has no licence of this code: look at the first results before you trust them.
!
! Run it with: ansys -b -i {p.name}.dat. It writes {p.name}.csv itself; then
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
R,30,{p.contact[0]!r},{p.contact[1]!r},0,{gap!r}
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
*DIM,LOAD1,TABLE,{p.steps}+1,,,TIME
*DIM,LOAD2,TABLE,{p.steps}+1,,,TIME
*DO,K,0,{p.steps}
  LOAD1(K+1,0)=K*{p.step!r}
  LOAD2(K+1,0)=K*{p.step!r}
  A=2*ACOS(-1)*MOD(K,{p.method.steps})/{p.method.steps}
  LOAD1(K+1,1)={load1}
  LOAD2(K+1,1)={load2}
*ENDDO
F,2,FX,%LOAD1%
F,3,FX,%LOAD2%
AUTOTS,OFF
KBC,0
DELTIM,{p.step!r}
OUTRES,ALL,NONE
OUTRES,NSOL,{p.every}
TIME,{p.end!r}
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
*CFOPEN,{p.name},csv
*VWRITE,'{head1}','{head2}','{head3}'
(A8,',',A8,',',A8)
*DIM,KEPT,ARRAY,ROWS
*DO,K,1,ROWS
  KEPT(K)=T(K)-({p.first!r})
*ENDDO
*VMASK,KEPT(1)
*VWRITE,T(1),X1(1),X2(1)
(E24.16,',',E24.16,',',E24.16)
*CFCLOS
FINISH
"""


def parts(problem: DeckProblem) -> dict[str, object]:
    """The rest of the template."""
    heads = problem.header.replace(" [", "[").split(", ")
    loads = [*(_load(body) for body in problem.bodies), "0"]
    return {
        **dict(zip(("head1", "head2", "head3"), heads, strict=True)),
        **dict(zip(("load1", "load2"), loads, strict=False)),
        "bodies": "\n".join(_bodies(problem)),
        "gap": problem.gap or _TOUCHING * problem.length,
        "second": _second_stop(problem),
        "wall": "D,3,UX,0\n" if problem.system.wall else "",
        "integrator": INTEGRATORS[problem.integrator.name](problem.integrator),
        "start": _start(problem),
    }


def _second_stop(problem: DeckProblem) -> str:
    """A contact whose nodes are exchanged: it acts where their distance has grown."""
    if not problem.system.two_stops:
        return ""
    stiffness, damping = problem.second_contact
    gap = problem.second_gap or _TOUCHING * problem.length
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
