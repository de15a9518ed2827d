"""check_programs.py SOURCE BUILD: the smallest runs of the programs of benchmarks/.

solver_benchmark, which has no small problem, is only built.
"""

import importlib.machinery
import importlib.util
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
programs = build / "benchmarks"


def run(program, *arguments):
    done = subprocess.run([programs / program, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, f"{program}: exit code {done.returncode}: {done.stdout}{done.stderr}"
    return done.stdout


def check_problems(folder):
    for name, filtered, benchmark in (("gram_benchmark", "order:25/", "BM_Dense"),
                                      ("path_benchmark", "order:25", "BM_Synthetic")):
        if not (programs / name).exists():  # without Google Benchmark
            print(f"{name} is left out")
            continue
        assert benchmark in run(name, f"--benchmark_filter={filtered}", "--benchmark_min_time=0.001")
    for form in ("numbers", "dates"):
        assert "200 samples every" in run("import_benchmark", "200", form, f"{folder}/rows.csv")
    assert "variance in operation" in run("filter_benchmark", "1", "1", "300")
    assert "right corrections:" in run("trial_benchmark", "tuning", "2", "2")
    assert "GBN, same set points" in run("plan_benchmark", "2", "1", "1", "1")
    assert "certified gap" in run("scale_benchmark", "2", "2", "300", "5", "1", "5")


def check_peer(folder):
    run("peer_problem", "write", folder, "gain", "1")
    run("peer_problem", "solve", folder, "path", "1")
    suboptimality, median, largest, count = run("peer_problem", "gap", folder).split()
    assert abs(float(suboptimality)) < 1e-6 and float(median) <= float(largest) < 1e-6 and int(count) == 100


def check_lives(folder):
    run("watch_benchmark", f"{folder}/lives.csv", source / "configs/wood_berry.json", "1", "0", folder, "gain", "white")
    assert pathlib.Path(folder, "lives.csv").read_text().startswith("white,gain,")
    subprocess.run([sys.executable, source / "benchmarks/watch/table.py", f"{folder}/lives.csv"], check=True,
                   stdout=subprocess.DEVNULL)


def check_decisions(folder):
    loader = importlib.machinery.SourceFileLoader("decisions", str(source / "benchmarks/scripts/decisions"))
    decisions = importlib.util.module_from_spec(importlib.util.spec_from_loader("decisions", loader))
    sys.modules["decisions"] = decisions
    loader.exec_module(decisions)
    decisions.APPS, decisions.RESULTS = build / "apps", pathlib.Path(folder)
    chosen = [case for case in decisions.cases() if case.name == "two_by_two, gains aged, q = 1e-6"]
    rows = decisions.study(chosen, [1])
    assert [(row["decision"], row["named"]) for row in rows] == [("corrected", 1)], rows
    assert decisions.study(chosen, [1]) == rows
    decisions.print_table(chosen, rows)


for check in (check_problems, check_peer, check_lives, check_decisions):
    with tempfile.TemporaryDirectory() as scratch:
        check(scratch)
