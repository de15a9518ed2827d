"""check_programs.py SOURCE BUILD: the smallest runs of the programs of benchmarks/.

solver_benchmark, which has no small problem, is only built.
"""

import pathlib
import subprocess
import sys
import tempfile

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


for check in (check_problems, check_peer, check_lives):
    with tempfile.TemporaryDirectory() as scratch:
        check(scratch)
