"""`python -m hdrm_fmu`: the machine, its FMUs for other tools, Monte Carlo, sensitivity and tuning from the command line."""

import argparse
import json
import shutil
import sys
from pathlib import Path

import hdrm_fmu
from hdrm_fmu import plots, studies
from hdrm_fmu.errors import BadInput, RunFailed, SweepStopped


def demo(args):
    follow = {"waypoints": args.waypoints} if args.waypoints else {"trajectory": args.trajectory}
    data = hdrm_fmu.run(mode=args.mode, metrics=("energy",), progress=True, **follow)
    a = data.attrs
    print(f"{args.waypoints or args.trajectory}, {args.mode}: tip RMSE {1e3 * a['tip_rmse']:.4f} mm, largest {1e3 * a['tip_max']:.4f} mm, verdict {a['verdict']}")
    if a["findings"]:
        print(a["findings"])
    print(f"{a['simulated']:.1f} s simulated in {a['elapsed']:.2f} s")
    plots.tip(data, args.out / "tip.png")
    plots.energy(data, args.out / "energy.png")
    print(f"figures in {args.out}")


def fmus(args):
    files = [*hdrm_fmu.fmus().values(), *hdrm_fmu.systems().values()]
    there = [file.name for file in files if (args.out / file.name).exists()]
    if there and not args.force:
        raise BadInput(f"{args.out} holds {', '.join(there)} already; --force overwrites")
    args.out.mkdir(parents=True, exist_ok=True)
    for file in files:
        shutil.copyfile(file, args.out / file.name)
        print(args.out / file.name)


def monte_carlo(args):
    options = {"modes": args.modes, "trajectories": args.trajectories, "waypoints": args.waypoints, "client": _client(args)}
    table = studies.monte_carlo(args.seeds, out=args.out / "monte-carlo", **options)
    print(studies.summary(table).to_string())
    plots.spread(table, path=args.out / "monte-carlo.png")


def sobol(args):
    ranges = dict(_range(text) for text in args.range)
    table = studies.sobol(ranges, out=args.out / "sobol", base=args.base, metric=args.metric, client=_client(args))
    print(table.to_string(index=False))
    plots.indices(table, args.out / "sobol.png")


def tune(args):
    gains = dict(_range(text) for text in args.range)
    fixed = dict(text.split("=", 1) for text in args.set)
    result, history = studies.tune(gains, metric=args.metric, runs=args.runs, settings=fixed)
    print(json.dumps(result, indent=1))
    for name in result["at_bound"]:
        print(f"{name} = {result['gains'][name]:g} is at a bound of its range: the best may lie beyond it")
    if result["bad"]:
        print(f"{result['bad']} of {len(history)} tries failed or had the verdict BAD")
    plots.tuning(history, args.out / "tuning.png")


def _client(args):
    if args.scheduler is None:
        return None
    from distributed import Client

    return Client(args.scheduler)


def _range(text):
    name, _, bounds = text.partition("=")
    try:
        low, high = map(float, bounds.split(":"))
    except ValueError:
        raise BadInput(f"`{text}` must be NAME=LOW:HIGH") from None
    return name, (low, high)


def arguments():
    parser = argparse.ArgumentParser(prog="python -m hdrm_fmu", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True)

    def command(function, help, out="hdrm_fmu", holds="results and figures"):
        sub = commands.add_parser(function.__name__.replace("_", "-"), help=help)
        sub.add_argument("--out", type=Path, default=Path(out), metavar="DIR", help=f"folder for {holds} (default: %(default)s)")
        sub.set_defaults(function=function)
        return sub

    sub = command(demo, "one run with its figures")
    motion = sub.add_mutually_exclusive_group()
    motion.add_argument("--trajectory", default="cubic", help="cubic or triangular (default: %(default)s)")
    motion.add_argument("--waypoints", metavar="FILE", help="path that the tip follows instead: a JSON or CSV file, or the name of a built-in path")
    sub.add_argument("--mode", default="adaptive", help=f"control law, one of {', '.join(hdrm_fmu.MODES)} (default: %(default)s)")
    sub = command(fmus, "write the packed FMUs (FMI 2.0) and systems, for other tools", "fmus", "the files")
    sub.add_argument("--force", action="store_true", help="overwrite files of these names")
    sub = command(monte_carlo, "control laws on many machines of the real world, whose bodies and sensors are drawn by seed; prints median, 95 %% quantile and worst")
    sub.add_argument("--seeds", type=int, default=20, metavar="N", help="machines, drawn by the seeds 1 to N (default: %(default)s)")
    sub.add_argument("--modes", nargs="+", default=["adaptive_integral", "modular_integral"], metavar="MODE", help=f"control laws, of {', '.join(hdrm_fmu.MODES)} (default: adaptive_integral modular_integral)")
    motion = sub.add_mutually_exclusive_group()
    motion.add_argument("--trajectories", nargs="+", metavar="NAME", help="cubic, triangular or both (default: cubic)")
    motion.add_argument("--waypoints", metavar="FILE", help="path that all follow instead of a trajectory")
    sub.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler; default: processes on this machine")
    sub = command(sobol, "which parameter matters: Sobol indices")
    default = ["hdrm.inertia_scale=0.8:1.2", "hdrm.payload.mass=0:100", "Lambda_position=5:25"]
    sub.add_argument("--range", nargs="+", default=default, metavar="NAME=LOW:HIGH", help=f"parameters and their ranges (default: {' '.join(default)})")
    sub.add_argument("--base", type=int, default=64, metavar="N", help="size of the base sample, a power of 2; N (k + 2) runs for k parameters (default: %(default)s)")
    sub.add_argument("--metric", default="tip_rmse", metavar="NAME", help="the number whose variance is explained (default: %(default)s)")
    sub.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler; default: processes on this machine")
    sub = command(tune, "gains that make a metric small on the cubic trajectory, judged on the triangular one")
    of = "gains and the ranges in which they are searched: scanned coarsely first, then refined from the best (default: Lambda_position=2:40 gamma=2:2000)"
    sub.add_argument("--range", nargs="+", default=["Lambda_position=2:40", "gamma=2:2000"], metavar="NAME=LOW:HIGH", help=of)
    of = "start values of all tries (default: hdrm.inertia_scale=1.2, a plant that is heavier than the controller thinks)"
    sub.add_argument("--set", nargs="+", default=["hdrm.inertia_scale=1.2"], metavar="NAME=VALUE", help=of)
    sub.add_argument("--metric", default="tip_rmse", metavar="NAME", help="what is made small, a number that `hdrm_fmu.run` gives (default: %(default)s)")
    sub.add_argument("--runs", type=int, default=60, metavar="N", help="tries at most, a run of 24 s simulated each (default: %(default)s)")
    return parser.parse_args()


def main():
    args = arguments()
    try:
        args.function(args)
    except (BadInput, RunFailed, SweepStopped) as error:
        sys.exit(f"error: {error}")
    except OSError as error:
        sys.exit(f"error: `{error.filename}`: {error.strerror}")


if __name__ == "__main__":
    main()
