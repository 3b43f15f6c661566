"""What was run, on what and how often: the text that stands beside each figure."""

from pathlib import Path

from ..accuracy.cases import StudyCase
from ..results.licences import licences_of
from .style import muscle_label

OFFSET = (
    "The error is the surface offset: at places of true contact, sampled over the whole motion, how far from the true "
    "surface the backend's answer changes between contact and none; 99th percentile (nearest rank) over the contacts, "
    "inwards or outwards, searched for within {band}. A backend that answers nowhere has that bound."
)
SUBSTITUTE = (
    "A hollow marker at the upper edge is a method that can't be asked about single points: it has a time, but no known error."
)
MEDIAN = "Time is update + detect + respond of one thread: the median over the frames without warm-up of all repetitions"
TIME = (
    f"{MEDIAN}, with its 95 % interval (bootstrap over repetitions and, in each, blocks of ten frames of the motion; not "
    "known of fewer than six frames)."
)


def write_caption(stem: Path, title: str, paragraphs: list[str], cases: list[StudyCase]) -> Path:
    path = stem.with_suffix(".md")
    texts = [f"**{title}**", *(text for text in paragraphs if text), provenance(cases)]
    path.write_text("\n\n".join(texts) + "\n")
    return path


def provenance(cases: list[StudyCase]) -> str:
    """Of the complete cases among them."""
    used = [case for case in cases if case.is_ok]
    if not used:
        return "Nothing of it has run yet."
    shapes = "; ".join(licences_of(case.run.record for case in used))
    return " ".join([_what(used), _how_often(used), _on_what(used), *([f"Licence of the shapes: {shapes}."] if shapes else [])])


def band_of(cases: list[StudyCase]) -> str:
    bands = sorted({case.run.record["band_m"] for case in cases if case.run.record.get("band_m")})
    return " and ".join(f"{1e3 * band:g} mm" for band in bands) or "the band"


def _what(cases: list[StudyCase]) -> str:
    muscles = [muscle_label(name) for name in dict.fromkeys(case.run.muscle for case in cases)]
    data = _several(case.scene.split("/")[0] for case in cases)
    presets = _several(case.run.record["case"].get("preset") for case in cases)
    text = f"Data: {data} ({', '.join(muscles)})"
    return f"{text}; preset {presets}." if presets else f"{text}."


def _how_often(cases: list[StudyCase]) -> str:
    counts: dict[tuple, int] = {}
    for case in cases:
        key = (case.mode, case.scene, case.configuration)
        counts[key] = counts.get(key, 0) + 1
    text = f"{len(cases)} runs of {len(counts)} configurations and scenes, each {_range(counts.values())} times"
    frames = [len(case.run.frames) for case in cases if len(case.run.frames)]
    if frames:
        text += f", {_range(frames)} frames a run"
    strides = {(case.run.record.get("recording") or {}).get("stride") for case in cases} - {None}
    if strides - {1}:
        text += f" (slow ones replay every {_range(strides)}th frame)" if len(strides) == 1 else \
            f" (slow ones replay fewer frames, down to every {max(strides)}th)"
    return text + "."


def _on_what(cases: list[StudyCase]) -> str:
    records = [case.run.record for case in cases]
    known = [
        _several((record.get("machine") or {}).get("cpu") for record in records),
        _several((record.get("build") or {}).get("compiler") for record in records),
        _several((record.get("build") or {}).get("flags") for record in records),
        _several(f"git {(record.get('build') or {}).get('git')}" for record in records
                 if (record.get("build") or {}).get("git") not in (None, "unknown")),
    ]
    return "Machine and build: " + "; ".join(text for text in known if text) + "."


def _several(values) -> str:
    return " and ".join(dict.fromkeys(str(value) for value in values if value))


def _range(values) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
