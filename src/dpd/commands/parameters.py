"""Repulsion of the beads of a fluid from its density and pressure, without a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.arguments import beads, no_less_than_zero, positive

if TYPE_CHECKING:
    from argparse import Namespace

    from dpd.commands.main import Stages


def add_to(stages: Stages) -> None:
    """Declare the stage."""
    parser = stages.add(
        "parameters", _parameters,
        "say which repulsion gives a fluid of beads or short chains a pressure, by three equations "
        "of state"
    )  # fmt: skip
    parser.add_argument(
        "--density", type=positive, required=True, metavar="RHO",
        help="molecules (not beads) per r_c^3",
    )  # fmt: skip
    parser.add_argument("--pressure", type=positive, required=True, help="in kT / r_c^3")
    parser.add_argument(
        "--beads", type=beads, default=1, metavar="M", help="of a molecule (default 1)"
    )
    parser.add_argument(
        "--length", type=no_less_than_zero, metavar="L",
        help="of a bond, in r_c; needed for 2 beads and more",
    )  # fmt: skip


def _parameters(options: Namespace) -> None:
    from dpd.errors import UserError
    from dpd.theory.equation_of_state import crgw, crgw_repulsion, gw_repulsion, rgw_repulsion

    rho, m, wanted = options.density, options.beads, options.pressure
    if m > 1 and options.length is None:
        raise UserError(f"parameters: --length is missing; molecules of {m} beads have bonds")
    length = options.length or 0.0
    try:
        repulsions = {
            "GW": gw_repulsion(m * rho, wanted),
            "rGW": rgw_repulsion(m * rho, wanted),
            "crGW": crgw_repulsion(rho, wanted, m, length),
        }
        pressures = [crgw(rho, a, m, length) for a in repulsions.values()]
    except ValueError as problem:
        raise UserError(f"parameters: {problem}") from None
    bonds = f" with bonds of {length:g} r_c" if m > 1 else ""
    print(f"molecules of {m} bead{'s' if m > 1 else ''}{bonds}, {rho:g} per r_c^3")
    print(f"beads     {m * rho:.6g} per r_c^3")
    print(f"pressure  {wanted:g} kT / r_c^3\n")
    print("equation  a in kT / r_c  pressure by crGW at this a")
    for (name, a), pressure in zip(repulsions.items(), pressures, strict=True):
        print(f"{name:8s}  {a:13.4g}  {pressure:26.4g}")
    print(
        "\nGW: Groot and Warren 1997; rGW: Liyana-Arachchi et al. 2015; crGW: Minkara et al. 2019, "
        "which alone knows of bonds"
    )
