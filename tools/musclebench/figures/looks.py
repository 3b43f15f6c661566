"""How the backends look in figures: colours, dashes and markers, as the program's list of backends tells them."""

from dataclasses import replace

from ..program.registry import Backend, Registry

DASHES = {"solid": "solid", "dashed": "dashed", "dotted": (0, (1, 1.2))}
# Of Okabe and Ito, for backends that name no colour of their own.
SPARE_COLOURS = ("#56B4E9", "#D55E00", "#F0E442")
SPARE_MARKERS = ("h", "p", "d", "X")
SERIES_STYLES = (("o", "-"), ("s", "--"), ("D", ":"), ("X", (0, (1, 1))), ("v", "-."), ("^", (0, (3, 1, 1, 1))))

_known = Registry(())


def know(registry: Registry) -> None:
    """From here on figures look as this list says; as the settings of matplotlib, it holds for the whole process."""
    global _known
    _known = registry


def known() -> Registry:
    return _known


def backend(name: str) -> Backend:
    """One with choices that its study names together looks like itself, in dots."""
    base, words = _with_choices(name)
    return replace(base, name=name, dash="dotted", study={**base.study, "title": f"{base.title} {words}"}) if words else base


def base_of(name: str) -> str:
    """The backend that does it."""
    return _with_choices(name)[0].name


def knows(name: str) -> bool:
    return _known.has(base_of(name))


def _with_choices(name: str) -> tuple[Backend, str]:
    """The backend, and what of the name its study says of a set of choices."""
    if not _known.has(name):
        for base in _known.backends:
            for one in base.study.get("named", []):
                if name == f"{base.label} {one['text']}":
                    return base, one["text"]
    return _known.backend(name), ""


def title(name: str) -> str:
    """What people call a backend."""
    return backend(name).title


def title_and_name(name: str) -> str:
    """For a key, in which a reader finds the name that commands and tables have."""
    alike = title(name).lower().replace(" ", "_") == name.lower().replace(" ", "_")
    return title(name) if alike else f"{title(name)} ({name})"


def series_title(backend_name: str, series: str) -> str:
    about = backend(backend_name)
    named = {f"{about.label} {one['name']}": one.get("title", one["name"]) for one in about.series if "name" in one}
    curve = named.get(series, series.removeprefix(about.label).strip())
    return f"{title_and_name(backend_name)}, {curve}"


def backends_in_order(names) -> list[str]:
    """Names without repetition, in the program's order; those that it doesn't know last."""
    names = set(names)
    known = sorted((name for name in names if knows(name)), key=lambda name: (_known.names.index(base_of(name)), name))
    return known + sorted(names - set(known))


def colour(name: str) -> str:
    return backend(name).colour or SPARE_COLOURS[_index(name) % len(SPARE_COLOURS)]


def dash(name: str):
    return DASHES.get(backend(name).dash or "solid", "solid")


def marker(name: str) -> str:
    """Of a single point."""
    return backend(name).study.get("marker") or SPARE_MARKERS[_index(name) % len(SPARE_MARKERS)]


def series_style(backend_name: str, series: str) -> tuple:
    """Marker and dash of a curve: the first of a backend is plain. What its study has beside its curves comes after them: single
    choices, and then each set of choices that has a name."""
    names = series_of(backend_name)
    sets = [one["text"] for one in backend(backend_name).study.get("named", [])]
    beside = next((place for place, text in enumerate(sets, 1) if text in series), 0)
    index = names.index(series) if series in names else len(names) + beside
    return SERIES_STYLES[index % len(SERIES_STYLES)]


def series_of(backend_name: str) -> list[str]:
    """Of a backend's study, as configurations name their curves."""
    about = backend(backend_name)
    return [f"{about.label} {one['name']}" for one in about.series if "sweep" in one and "name" in one]


def curved_backends() -> list[str]:
    """Those whose answers get better with resolution."""
    return [name for name in _known.names if series_of(name)]


def all_series() -> list[str]:
    return [series for name in _known.names for series in series_of(name)]


def _index(name: str) -> int:
    return _known.names.index(name) if name in _known.names else len(_known.names)
