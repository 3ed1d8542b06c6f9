"""Repulsions from the parameter chi, without a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.arguments import beads, positive

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    parser = stages.add(
        "repulsion", _repulsion,
        "say which repulsions give two species a Flory-Huggins parameter chi"
    )  # fmt: skip
    parser.add_argument("--chi", type=positive, required=True, help="of two beads, chi_AB")
    parser.add_argument(
        "--density", type=positive, default=3.0, metavar="RHO",
        help="beads per r_c^3: 3 (default) or 5",
    )  # fmt: skip
    parser.add_argument(
        "--length", type=beads, default=1, metavar="N",
        help="beads of a molecule of A, and of one of B: 1 (default) to 10",
    )  # fmt: skip
    parser.add_argument("--kT", type=positive, default=1.0, help="temperature (default 1)")


def _repulsion(options: Namespace) -> None:
    from dpd.errors import UserError
    from dpd.theory.repulsion import LEAST, like_repulsion, relation_at, unlike_repulsion

    try:
        relation = relation_at(options.density, options.length)
        like = like_repulsion(options.density, options.kT)
        unlike = unlike_repulsion(options.chi, options.density, options.length, options.kT)
    except ValueError as problem:
        raise UserError(f"repulsion: {problem}") from None
    lowest, highest = relation.chi_range(options.length)
    rows = {
        "a_AA = a_BB": f"{like:.6g} kT / r_c, 75 kT / density: the compressibility of water",
        "a_AB": f"{unlike:.6g} kT / r_c",
        "chi N": f"{options.chi * options.length:.6g}",
        "relation": str(relation),
        "range": f"chi from {lowest:.3g} (chi N = {LEAST:g}) to {highest:g}",
        "in a scene": f"repulsion: {{A A: {like:.6g}, B B: {like:.6g}, A B: {unlike:.6g}}}",
    }
    for name, value in rows.items():
        print(f"{name:12s} {value}")
