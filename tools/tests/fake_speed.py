#!/usr/bin/python3
"""Stands in for the program and for its kernels, with known numbers: `list`, `probe` and `run` as musclebench, else as a Google
Benchmark program. FAKE_BEHAVIOUR maps words of the command line to misbehaviour, such as "voxel_test=crash allocations=empty";
FAKE_LOG gets one line a call."""

import json
import os
import re
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1])]

import fake_registry  # noqa: E402  (found through the path that is set above)

ROLES = fake_registry.roles()
# Collision time a frame, ns, of each backend; the clearance cache saves most of it.
COLLISION_NS = {ROLES.unit: 50_000, ROLES.field: 60_000, ROLES.exact: 125_000}
SLOWER_WITHOUT_CACHE = 4
HEAD = "frame,angle_deg,warm_up,update_ns,detect_ns,respond_ns,frame_ns,contacts,nodes_inside,max_depth_m," \
       "mean_depth_m,missed_contacts,false_contacts,resident_bytes\n"
# (kernel as the program calls it, counter, value, unit of the time); a counter real_time is the time itself
KERNELS = [
    *[(f"voxel_test/{bone}", "ns_a_point", 6.0) for bone in ("pelvis", "femur")],
    ("sdf_value_and_gradient/pelvis", "ns_a_point", 24.0),
    ("sdf_value_and_gradient/femur", "ns_a_point", 66.0),
    *[(f"bvh_locate/near/{bone}", "ns_a_point", 1000.0) for bone in ("pelvis", "femur")],
    ("sdf_build_a_node/pelvis", "ns_a_node", 250.0), ("sdf_build_a_node/femur", "ns_a_node", 150.0),
    ("sdf_build_threads/femur/1", "real_time", 190.0), ("sdf_build_threads/femur/2", "real_time", 100.0),
    ("detect_threads/bvh/1", "real_time", 900.0), ("detect_threads/bvh/2", "real_time", 500.0),
    ("detect_threads/sdf/1", "real_time", 300.0), ("detect_threads/sdf/2", "real_time", 200.0),
    *[(f"muscle_size/{backend}/{10**n}", "real_time", 2.0 * 10**n) for backend in COLLISION_NS
      for n in (3, 4, 5)],
    *[(f"bone_size/bvh_locate/{20 * 4**n}", "ns_a_point", 100.0 * n) for n in (4, 5, 6, 7)],
    *[(f"bone_size/bvh_step/{20 * 4**n}", "real_time", 70.0) for n in (4, 5, 6, 7)],
    ("sdf_bytes/pelvis", "bytes", 7.5e6), ("sdf_bytes/femur", "bytes", 7.6e6),
    *[(f"constraints/edge_length/{how}", "ns_a_constraint", ns)
      for how, ns in (("lanes", 2.0), ("scalar", 8.0), ("published", 30.0))],
    *[(f"constraints/bending/{how}", "ns_a_constraint", ns)
      for how, ns in (("lanes", 10.0), ("lanes_of_avx2", 12.5), ("scalar", 40.0), ("published", 60.0))],
    *[(f"loop/standard/null/{how}", "real_time", us) for how, us in (("scalar", 4e4), ("1", 1e4), ("2", 6250.0))],
    *[(f"loop/standard/sdf/{how}", "real_time", us) for how, us in (("scalar", 4.5e4), ("2", 9e3))],
    *[(f"loop/paper/null/{how}", "real_time", us) for how, us in (("scalar", 5e3), ("1", 1e3))],
    *[(f"loop/paper/sdf/{how}", "real_time", us) for how, us in (("scalar", 6e3), ("1", 2e3))],
    *[(f"muscles/sdf/{threads}", "real_time", 6e4 / threads) for threads in (1, 2)],
    ("allocations/bvh/project", "allocations", 0.0), ("allocations/voxel/backtrack", "allocations", 3.0),
]
TIME_OF_COUNTER = {"ns_a_node": 1e6, "bytes": 5.0, "allocations": 5.0}


def behaviour() -> str:
    wanted = dict(item.rsplit("=", 1) for item in os.environ.get("FAKE_BEHAVIOUR", "").split())
    return next((what for word, what in wanted.items() if any(word in argument for argument in sys.argv[1:])), "")


def run(arguments: list[str]) -> int:
    backend = arguments[arguments.index("--backend") + 1]
    repetition = int(arguments[arguments.index("--repetition") + 1])
    a_frame = COLLISION_NS[backend] * (SLOWER_WITHOUT_CACHE if "clearance_cache=off" in arguments else 1)
    folder = Path(arguments[arguments.index("--out") + 1])
    folder.mkdir(parents=True)
    lines = [f"{frame},{frame},{int(frame <= 2)},{0.1 * a_frame},{0.8 * a_frame},{0.1 * a_frame},9e6,5,,,,,,1000\n"
             for frame in range(1, 41)]
    (folder / "frames.csv").write_text(HEAD + "".join(lines))
    case = {"mode": "coupled", "scene": arguments[1], "backend": backend, "parameters": {}, "threads": 1,
            "repetition": repetition, "judged": "--no-referee" not in arguments}
    record = {"status": "ok", "status_detail": "", "case": case, "frames": 40, "schema_version": 2,
              "implementations": {backend: f"library of {backend}"},
              "build": {"git": "abc"}, "machine": {"cpu": "A processor", "cores": 2},
              "muscle": {"nodes": 7_000 if arguments[1].endswith("iliacus") else 3_000}, "build_ns": 600_000_000,
              "cpu_ns": {"before_first_frame": 1_000_000_000,
                         "after_last_frame": 8_000_000_000 if case["judged"] else 4_000_000_000}}
    (folder / "run.json").write_text(json.dumps(record))
    return 0


def time_kernels(options: dict[str, str]) -> int:
    results = []
    for kernel, counter, value in KERNELS:
        if not re.search(options["benchmark_filter"], kernel):
            continue
        for repetition in range(int(options.get("benchmark_repetitions", 1))):
            result = {"name": kernel, "run_name": f"{kernel}/real_time", "run_type": "iteration",
                      "repetition_index": repetition, "iterations": 10, "time_unit": "us"}
            # All counters of a repetition swing together, as on a machine that is slower now and then.
            swing = 1 + 0.01 * repetition
            time = swing * (value if counter == "real_time" else TIME_OF_COUNTER.get(counter, 8.0))
            result |= {"real_time": time, "cpu_time": time}
            if counter != "real_time":
                result[counter] = value * (swing if counter.startswith("ns_") else 1)
            results.append(result)
        results.append({"name": f"{kernel}_median", "run_name": kernel, "run_type": "aggregate", "real_time": -1,
                        "cpu_time": -1})
    if re.search(options["benchmark_filter"], "adaptive_over_uniform/femur"):
        results.append({"name": "adaptive_over_uniform/femur", "run_name": "adaptive_over_uniform/femur",
                        "run_type": "iteration", "error_occurred": True, "error_message": "sdf: no 'max_error_mm'"})
    Path(options["benchmark_out"]).write_text(json.dumps({"context": {}, "benchmarks": results}))
    return 0


def main() -> int:
    arguments = sys.argv[1:]
    if arguments == ["list", "--json"]:
        print(fake_registry.text())
        return 0
    if arguments[0] == "probe":
        told = dict(zip(arguments[2::2], arguments[3::2]))
        fake_registry.write_survey(Path(told["--out"]), arguments[1], int(told.get("--frames", 314)))
        return 0
    if "FAKE_LOG" in os.environ:
        with open(os.environ["FAKE_LOG"], "a") as log:
            print(*sorted(os.sched_getaffinity(0)), *arguments, file=log)
    if behaviour() == "crash":
        print("musclebench: something went wrong", file=sys.stderr)
        return 2
    if arguments[0] == "run":
        return run(arguments)
    return time_kernels(dict(argument.removeprefix("--").split("=", 1) for argument in arguments))


if __name__ == "__main__":
    sys.exit(main())
