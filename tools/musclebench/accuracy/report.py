"""Writes all that the accuracy study shows: rows, tables, figures with their captions."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..experiments.caveats import caveats
from ..figures import captions, looks
from ..figures.convergence import draw_costs, draw_errors
from ..figures.offset_and_depth import draw_offsets, offset_rows, told
from ..figures.library_costs import draw_library_costs
from ..figures.overview import draw_overview
from ..figures.pareto import Emphasis, draw_pareto
from ..figures.stages import draw_stages, stage_rows
from ..program.optional_packages import left_out_without
from ..program.registry import saved_registry, whose
from ..results.disturbance import note
from ..tables import table_formats
from ..tables.arm_prices import arm_price_list, arm_table
from ..tables.choices import choices_tables, rule
from ..tables.difficulties import difficulties_table
from ..tables.force_table import force_table
from ..tables.outcomes import outcomes_table, shape_distances
from ..tables.prices import price_list
from ..tables.table_formats import Table
from . import coupled_faults
from .aggregates import Aggregate, aggregates_of, of_mode
from .arm_errors import RULE, arm_errors
from .cases import StudyCase, read_cases
from .force_errors import RULE as FORCE_RULE
from .force_errors import force_errors
from .front import points_of
from .orders import cost_rows, probe_rows
from .rows import accuracy_rows, build_seconds_of, study_rows

OVERVIEW_WORDS = (
    "Shown are the default of each backend, what its makers or users advise, and one curve over its resolution; on several "
    "muscles the sum of their times and the largest of their errors. The grey line is the Pareto front of these points. "
    "Errors below a micrometre count as equal. A hollow marker at the upper edge is a method that can't be asked about single "
    "points: it has no offset. Crossed-out configurations are wrong. At most eight points have their names beside them. A "
    "marker's area grows with the bytes of the collision structures."
)
FRONT_WORDS = (
    "The grey line is the Pareto front: nothing is both faster and more accurate than what lies on it. Crossed-out "
    "configurations are wrong and not on it; errors below a nanometre count "
    "as equal and are drawn at one height, below the break of the axis. At most eight points of a panel have their names "
    "beside them; the page names all. A marker's area grows with the bytes of the "
    "structures, a step a factor of ten. All muscles: the sum of their times, the largest of their errors, of "
    "configurations that are complete on each.")


@dataclass
class AccuracyReport:
    files: list[Path]
    tables: list[Table]  # price list, choices of backends that have many, outcomes of coupled runs

    def __iter__(self) -> Iterator[Path]:
        return iter(self.files)


def write_report(out_dir: Path) -> AccuracyReport:
    """Of out_dir/raw and out_dir/experiment.json, however much of the study there is. Cases that failed or are missing stand
    in accuracy.csv and study.csv with their status."""
    cases = read_cases(out_dir)
    if cases:
        looks.know(saved_registry(out_dir))
    aggregates = aggregates_of(cases)
    figures, tables = out_dir / "figures", out_dir / "tables"
    for folder in (figures, tables):
        folder.mkdir(parents=True, exist_ok=True)
    builds = build_seconds_of(aggregates)
    files = _write_rows(cases, aggregates, builds, out_dir)
    replays, coupled = of_mode(aggregates, "replay"), of_mode(aggregates, "coupled")
    wrong = {(aggregate.scene, aggregate.configuration) for aggregate in replays if aggregate.is_wrong}
    floors, shapes = of_mode(aggregates, "floor"), shape_distances(coupled)
    faults = coupled_faults.faults_of(coupled, shapes)
    armed = of_mode(aggregates, "arms")
    armed_floors = of_mode(aggregates, "arms_floor")
    arms = arm_errors(armed, armed_floors)
    forces = force_errors(of_mode(aggregates, "forces"), of_mode(aggregates, "forces_floor"))
    made = [price_list(replays, builds), arm_price_list(armed, arms, wrong), arm_table(armed, arms), force_table(armed, forces),
            *choices_tables(replays), difficulties_table(replays), outcomes_table(coupled, shapes, floors)]
    sentence = whose({one.configuration.backend: one.configuration.about.implementation for one in aggregates})
    made = [table.with_sentence(sentence).with_sentence(caveats(out_dir)) for table in made if not table.rows.empty]
    busy = note({case.name: case.disturbance for case in cases if case.disturbance}, len(cases))
    for table in made:
        files += _write_table(table, tables, busy)
    with left_out_without("the figures"):
        files += _draw_replay(replays, wrong, figures)
        files += _draw_offsets(replays, figures)
        files += _draw_coupled(coupled, wrong, shapes, faults, figures)
        files += _draw_arms(armed, wrong, arms, figures)
        files += _draw_forces(armed, wrong, forces, figures)
        files += _draw_convergence(aggregates, builds, figures)
        files += _draw_stages(coupled, replays, figures)
        files += _draw_libraries(study_rows(aggregates, builds), replays, figures)
    return AccuracyReport(files, made)


def _write_rows(cases: list[StudyCase], aggregates: list[Aggregate], builds: dict, out_dir: Path) -> list[Path]:
    paths = [out_dir / "accuracy.csv", out_dir / "study.csv"]
    accuracy_rows(cases).to_csv(paths[0], index=False)
    study_rows(aggregates, builds).to_csv(paths[1], index=False)
    return paths


def _write_table(table: Table, folder: Path, busy: str) -> list[Path]:
    """`busy`: of the machine, below the table."""
    text = folder / f"{table.name}.txt"
    text.write_text(f"{table.caption}\n\n{table_formats.as_text(table)}\n{_notes(table)}{busy}\n")
    return [*table_formats.write_table(table, folder), text]


def _notes(table: Table) -> str:
    """Lines for a terminal, where a column of notes has no room."""
    if "note" not in table.rows:
        return ""
    rows = table.rows[table.rows["note"] != ""]
    lines = [f"{row['muscle']}, {row['target_mm']} mm: {row['note']}" for _, row in rows.iterrows()]
    return "\n".join(["", *lines, ""]) if lines else ""


def _draw_replay(replays: list[Aggregate], wrong: set, folder: Path) -> list[Path]:
    points = points_of(replays, lambda one: one.p99_offset_mm if one.is_asked else math.inf, wrong, lambda one: not one.is_asked)
    title = "What accuracy costs in time: the same positions for every backend (replay)"
    files = draw_pareto(points, folder / "pareto_replay", title, "surface offset, 99th percentile (mm)", Emphasis("exact"))
    offset = captions.OFFSET.format(band=captions.band_of(_cases(replays)))
    texts = [f"{offset} {captions.SUBSTITUTE}", captions.TIME, FRONT_WORDS, rule(), _left_out(replays, points)]
    all_points = _with_caption(files, title, texts, _cases(replays))
    title = "What accuracy costs: all backends at the same positions"
    files = draw_overview(points, folder / "overview", title)
    return all_points + _with_caption(files, title, [offset, f"{captions.MEDIAN}.", OVERVIEW_WORDS, rule(), _left_out(replays, points)], _cases(replays))


def _draw_offsets(replays: list[Aggregate], folder: Path) -> list[Path]:
    rows = offset_rows(replays)
    title = "Does the surface offset tell what a run leaves?"
    files = draw_offsets(rows, folder / "offset_and_depth")
    texts = ["Across: how far inwards the backend's surface is, 99th percentile over the contacts (replay). Up: how deep "
             "nodes are when the backend moves its own muscle, 99th percentile over the contacts of all frames. In the band "
             "they agree within a factor of two. Below 0.001 mm counts as that.", told(rows)]
    return _with_caption(files, title, texts, _cases(replays))


def _draw_coupled(coupled: list[Aggregate], wrong: set, shapes: dict, faults: dict, folder: Path) -> list[Path]:
    def distance(aggregate: Aggregate) -> float:
        return shapes.get((aggregate.scene, aggregate.configuration), {}).get("full_rms_mm", math.nan)

    wrong, why = wrong | set(faults), coupled_faults.told(faults)
    depths = points_of(coupled, lambda aggregate: aggregate.remaining_depth_mm, wrong)
    title = "What accuracy costs in time: every backend moves its own muscle (coupled)"
    files = draw_pareto(depths, folder / "pareto_coupled", title, "remaining depth, 99th percentile (mm)", Emphasis("none left"))
    error = (
        "The error is the true depth that remains at the end of a frame, by the Referee: the deepest point of a "
        "muscle triangle inside a bone or of a bone's vertex inside the muscle (of the nodes where the surface was "
        "not judged), 99th percentile over the run's frames. Little depth is not yet accuracy: a backend that keeps "
        "the muscle too far from the bones leaves none; the figure of shapes shows what that costs. "
        "Trajectories part: the table of coupled outcomes has times of whole runs.")
    texts = [error, captions.TIME, FRONT_WORDS, coupled_faults.RULE, why, _left_out(coupled, depths)]
    files = _with_caption(files, title, texts, _cases(coupled))
    distances = points_of(coupled, distance, wrong)
    title = "How far the muscle's shape at full flexion is from the exact run's (coupled)"
    stem, axis_title = folder / "pareto_coupled_shape", "distance to exact shape, RMS (mm)"
    drawn = draw_pareto(distances, stem, title, axis_title, Emphasis("same shape"))
    error = "The error is the root mean square over all nodes of their distance to the same nodes of the exact run."
    texts = [error, captions.TIME, FRONT_WORDS, coupled_faults.RULE, why, _left_out(coupled, distances)]
    return files + _with_caption(drawn, title, texts, _cases(coupled))


def _draw_arms(armed: list[Aggregate], wrong: set, arms: dict, folder: Path) -> list[Path]:
    def error(aggregate: Aggregate) -> float:
        return arms.get((aggregate.scene, aggregate.configuration), {}).get("arm_rms_mm", math.nan)

    points = points_of(armed, error, wrong)
    title = "What a backend's accuracy is worth in moment arms (coupled)"
    files = draw_pareto(points, folder / "pareto_moment_arm", title, "moment arm off by, RMS (mm)", Emphasis("same arm"))
    floors = {one.muscle: arms[(one.scene, one.configuration)]["arm_floor_mm"] for one in armed
              if (one.scene, one.configuration) in arms}
    told = ", ".join(f"{muscle.replace('_', ' ')} {floor:.2g} mm" for muscle, floor in floors.items() if floor == floor)
    texts = [RULE, f"Floors: {told}." if told else "", captions.TIME, FRONT_WORDS, rule(),
             _left_out(armed, points)]
    return _with_caption(files, title, texts, _cases(armed))


def _draw_forces(told: list[Aggregate], wrong: set, forces: dict, folder: Path) -> list[Path]:
    files = []
    for what, words in (("torque", "joint torque"), ("pressure", "peak contact pressure"), ("map", "pressure over bones")):
        def error(aggregate: Aggregate, key=f"{what}_percent") -> float:
            return forces.get((aggregate.scene, aggregate.configuration), {}).get(key, math.nan)

        points = points_of(told, error, wrong)
        title = f"What a backend's accuracy is worth in {words} (coupled)"
        drawn = draw_pareto(points, folder / f"pareto_{what}", title, f"{words} off by, RMS (%)", Emphasis("same"))
        floors = {one.muscle: forces[(one.scene, one.configuration)][f"{what}_floor_percent"] for one in told
                  if (one.scene, one.configuration) in forces}
        numbers = ", ".join(f"{muscle.replace('_', ' ')} {floor:.2g} %" for muscle, floor in floors.items() if floor == floor)
        texts = [FORCE_RULE, f"Floors: {numbers}." if numbers else "", captions.TIME, FRONT_WORDS, rule(), _left_out(told, points)]
        files += _with_caption(drawn, title, texts, _cases(told))
    return files


def _draw_convergence(aggregates: list[Aggregate], builds: dict, folder: Path) -> list[Path]:
    probes = of_mode(aggregates, "probe")
    title = "Error against cell size at points about the bones"
    files = draw_errors(probe_rows(probes), folder / "convergence")
    bands = sorted({case.run.record["case"].get("band_m") or 0 for case in _cases(probes)} - {0})
    near = f" within {' and '.join(f'{1e3 * band:g} mm' for band in bands)} of the surface" if bands else ""
    texts = [f"99th percentile of the depth error of points sampled about each bone{near}, at smooth regions and near "
             "sharp edges; a method that knows only inside and outside can't err by more than that distance, "
             "so that its curve is flat at coarse cells; the edge of a cell is that of the bone's grid. Orders are "
             "slopes of straight lines through the logarithms, over all resolutions in the legend and between "
             "neighbouring ones in the CSV. An order that falls off at fine cells says that something else limits "
             "the error."]
    files = _with_caption(files, title, texts, _cases(probes))
    title = "What resolution costs before the first frame"
    drawn = draw_costs(cost_rows(probes or aggregates, builds), folder / "convergence_cost")
    texts = ["Build time and bytes of the structures of all bones of a scene against their number of cells, of grids "
             "with a fixed count of cells; slopes of straight lines through the logarithms. Bones that scenes share "
             "count once. Bytes hold what clearance caches keep of the muscle's nodes, too."]
    return files + _with_caption(drawn, title, texts, _cases(probes or aggregates))


def _draw_stages(coupled: list[Aggregate], replays: list[Aggregate], folder: Path) -> list[Path]:
    title = "Where the time of a frame goes"
    files = draw_stages(stage_rows(coupled, replays), folder / "stages")
    texts = ["Medians over the frames without warm-up of each stage of the loop, as shares of their sum; the words "
             "tell milliseconds a frame. Each backend in its default; of one with many choices also the fastest "
             "configuration that answers right on replayed positions. Judging and writing are outside."]
    return _with_caption(files, title, texts, _cases(coupled))


def _draw_libraries(study, replays: list[Aggregate], folder: Path) -> list[Path]:
    made: list[Path] = []
    for library, files in draw_library_costs(study, folder).items():
        texts = [captions.TIME, "Off by: the surface offset, 99th percentile over the contacts; \"-\": it is not asked about points."]
        made += _with_caption(files, f"What {looks.title(library)} costs in its configurations", texts, _cases(replays))
    return made


def _with_caption(files: list[Path], title: str, texts: list[str], cases: list[StudyCase]) -> list[Path]:
    return [*files, captions.write_caption(files[0], title, texts, cases)] if files else []


def _left_out(aggregates: list[Aggregate], points) -> str:
    """What of the plan is not in a picture, and why."""
    absent = [f"{aggregate.muscle} with {aggregate.configuration.name} ({aggregate.status})" for aggregate in aggregates
              if not aggregate.is_shown]
    drawn = set(zip(points["panel"], points["configuration"]))
    unknown = [f"{one.muscle} with {one.configuration.name} (no error known)" for one in aggregates if one.is_shown
               and one.configuration.threads == 1 and (one.scene, one.configuration.name) not in drawn]
    names = absent + unknown
    return f"Not shown: {', '.join(names)}. Runs of several threads are in the tables." if names else ""


def _cases(aggregates: list[Aggregate]) -> list[StudyCase]:
    return [case for aggregate in aggregates for case in aggregate.cases]
