"""Labels, colours and dashes of backends, as the registry beside the results tells them."""

from ..figures import looks

# Of Okabe and Ito, one after the other for runs that are told apart by other names than those of backends.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def looks_of_names(names) -> dict[str, dict]:
    """{name: {label, colour, dash}}; other people's libraries last, as a page has few toggles."""
    found = sorted(looks.backends_in_order(names), key=lambda name: looks.backend(name).is_external)
    unknown = [name for name in found if not looks.knows(name)]
    return {name: {"label": looks.title(name), "dash": looks.backend(name).dash or "solid",
                   "colour": COLOURS[unknown.index(name) % len(COLOURS)] if name in unknown else looks.colour(name)}
            for name in found}
