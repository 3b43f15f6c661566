"""Labels, colours and dashes of backends, as the registry beside the results tells them."""

from ..figures import looks


def looks_of(runs) -> dict[str, dict]:
    """{backend: {label, colour, dash, control}} of those that were run, in the registry's order."""
    return looks_of_names(run.backend for run in runs)


def looks_of_names(names) -> dict[str, dict]:
    return {name: {"label": looks.backend(name).label, "colour": looks.colour(name),
                   "dash": looks.backend(name).dash or "solid", "control": looks.backend(name).is_control}
            for name in looks.backends_in_order(names)}
