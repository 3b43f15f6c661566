"""Configurations: a backend with what differs from its defaults, and the names that figures and tables give them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..program.registry import SIZE_ROLES, Backend, Parameter, plain_value

MM_OF_UNIT = {"m": 1e3, "mm": 1.0}


@dataclass(frozen=True)
class Configuration:
    backend: str
    choices: tuple[tuple[str, str], ...] = ()  # parameters that differ from the defaults, by name
    threads: int = 1
    about: Backend = field(default=Backend("", ""), compare=False, repr=False)

    @property
    def is_default(self) -> bool:
        return not self.choices and self.threads == 1

    @property
    def is_advised(self) -> bool:
        """As its makers or its users advise: the defaults, where the study names no others."""
        return self == configuration(self.about, self.about.study.get("advised", {}))

    @property
    def is_unit_of_price(self) -> bool:
        """What times are divided by."""
        parameters = self.about.study.get("advise", {}).get("unit_of_price")
        return parameters is not None and self == configuration(self.about, parameters)

    @property
    def named_set(self) -> str:
        """What the study calls its choices together; empty: nothing."""
        words, _ = self._named_together()
        return words[0][1] if words else ""

    @property
    def factors(self) -> int:
        """How many choices differ from the default."""
        return len(self.choices) + (self.threads != 1)

    @property
    def size(self) -> Parameter | None:
        """What says how fine it is: a wanted error where there is one, an edge of cells, else their count along each
        axis; None for backends without a resolution."""
        sizes = [one for one in self.about.parameters if one.role in SIZE_ROLES]
        sizes.sort(key=lambda one: (one.role != "wanted_error", one.unit == ""))
        return next((one for one in sizes if one.unit == "" or self._number(one) > 0), None)

    @property
    def cells(self) -> int | None:
        """Along each axis; None for cubes, for adaptive cells and for backends without a grid."""
        is_count = self.size is not None and self.size.unit == "" and self.size.kind == "integer"
        return int(self._number(self.size)) if is_count else None

    @property
    def cube_edge_m(self) -> float | None:
        return 1e-3 * self._size_mm() if self.size is not None and self._is_length("resolution") else None

    @property
    def wanted_error_mm(self) -> float | None:
        """Of adaptive cells."""
        return self._size_mm() if self.size is not None and self._is_length("wanted_error") else None

    @property
    def series(self) -> str | None:
        """Name of the curve over resolutions on which the configuration lies; None for a single point."""
        if self.size is None:
            return None
        name = next((one.get("name") for one in self.about.series if self._lies_on(one)), None)
        return f"{self.about.label} {name or ' '.join([*self._words_beside_size(), _without_unit(self.size.name)])}"

    @property
    def fineness(self) -> float:
        """Grows with resolution along a series."""
        if self.size is None:
            return 0.0
        return self._number(self.size) if self.size.unit == "" else 1e3 / self._size_mm()

    @property
    def short(self) -> str:
        """Resolution, or the choices that make the point."""
        if self.size is None:
            return ", ".join(text for _, text in self._spoken()) or "default"
        if self.wanted_error_mm is not None:
            return f"to {self.wanted_error_mm:g} mm"
        return f"{self._number(self.size):g}" if self.size.unit == "" else f"{self._size_mm():g} mm"

    @property
    def name(self) -> str:
        """Unambiguous and short: a label, a label with a resolution, a label with the choices that make the point."""
        if self.size is not None:
            return " ".join([self.about.label, self.short, *self._words_beside_size()])
        is_told = not self.is_default or self.about.has_many_choices
        return f"{self.about.label} {self.short}" if is_told else self.about.label

    @property
    def spoken(self) -> str:
        """As people write it: `distance field, 32 cells, no cache`."""
        if self.size is not None:
            return ", ".join([self.about.title, self._spoken_size(), *self._words_beside_size()])
        if self.is_default and "default_words" in self.about.study:
            return f"{self.about.title}, {self.about.study['default_words']}"
        is_told = not self.is_default or self.about.has_many_choices
        return f"{self.about.title}, {self.short}" if is_told else self.about.title

    def choice(self, key: str) -> str:
        return dict(self.choices).get(key, plain_value(self.about.parameter(key).default))

    def _number(self, parameter: Parameter) -> float:
        return float(self.choice(parameter.name) or 0)

    def _size_mm(self) -> float:
        return MM_OF_UNIT[self.size.unit] * self._number(self.size)

    def _spoken_size(self) -> str:
        if self.cells is not None:
            return f"{self.cells} {_without_unit(self.size.name)}"
        if self.cube_edge_m is not None:
            return f"{self.short} cells"
        return self.short if self.wanted_error_mm is not None else f"{_without_unit(self.size.name)} {self.short}"

    def _is_length(self, role: str) -> bool:
        return self.size.role == role and self.size.unit in MM_OF_UNIT

    def _lies_on(self, series: dict) -> bool:
        """Whether only the swept parameter tells it from the series' other configurations."""
        if self.size.name not in series.get("sweep", {}) or series.get("threads", 1) != self.threads:
            return False
        like = configuration(self.about, series.get("fixed", {}) | {self.size.name: self.choice(self.size.name)})
        return like.choices == self.choices

    def _words_beside_size(self) -> list[str]:
        sizes = {one.name for one in self.about.parameters if one.role in SIZE_ROLES}
        return [text for key, text in self._spoken() if key not in sizes]

    def _spoken(self) -> list[tuple[str, str]]:
        cache = self.about.of_role("clearance_cache")
        ordered = sorted(self.choices, key=lambda choice: cache is not None and choice[0] == cache.name)
        words, told = self._named_together()
        words += [(key, self._word(key, value)) for key, value in ordered if key not in told]
        return words + ([("threads", f"{self.threads} threads")] if self.threads != 1 else [])

    def _named_together(self) -> tuple[list[tuple[str, str]], set[str]]:
        """The name that the study gives to a set of choices, and their parameters; for the first set that is there."""
        for one in self.about.study.get("named", []):
            wanted = {key: plain_value(value) for key, value in one["parameters"].items()}
            if wanted.items() <= dict(self.choices).items():
                return [("", one["text"])], set(wanted)
        return [], set()

    def _word(self, key: str, value: str) -> str:
        """As the study says it; lengths in mm; else the parameter and its value."""
        for told in self.about.study.get("words", []):
            if told["parameter"] == key and plain_value(told.get("value", value)) == value:
                return told["text"].replace("{value}", value)
        if self.about.parameter(key).unit == "m":
            return f"{_without_unit(key)} {1e3 * float(value):g} mm"
        return f"{key.replace('_', ' ')} {value}"


def configuration(backend: Backend, parameters: Mapping, threads: int = 1) -> Configuration:
    """Of resolved parameters or of those that were asked for: the same. Where structures are kept makes no other."""
    told = {key: plain_value(value) for key, value in parameters.items() if backend.parameter(key).role != "storage"}
    known = {parameter.name: plain_value(parameter.default) for parameter in backend.parameters}
    choices = {key: value for key, value in told.items() if value != known.get(key)}
    choices = {key: value for key, value in choices.items() if backend.matters(key, known | choices)}
    size = Configuration(backend.name, tuple(choices.items()), threads, backend).size
    unused = {one.name for one in backend.parameters if one.role in SIZE_ROLES and one != size}
    chosen = sorted((key, value) for key, value in choices.items() if key not in unused)
    return Configuration(backend.name, tuple(chosen), threads, backend)


def _without_unit(name: str) -> str:
    return name.removesuffix("_mm").removesuffix("_m").replace("_", " ")
