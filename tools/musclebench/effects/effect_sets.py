"""Which sets of effects are compared: the scene's own, all, each of all left out, each added to the scene's own."""

from dataclasses import dataclass

LOADS = ("gravity", "activation", "fibre_force")  # move the muscle; the others say how it answers. Not among all unless a scene has one
OF_TABLES = ("retinaculum",)  # acts on tables of the scene's, and does nothing in a scene without them
# Not left out: without attachments a muscle stays where it is, and without edges its surface has no shape to keep, falls
# together and touches itself everywhere (a run of the largest muscle did not end within minutes).
KEPT = ("attachment", "edge_length")
OWN, ALL = "own", "all"


@dataclass(frozen=True)
class EffectSet:
    """`name`: own, all, all-EFFECT or own+EFFECT."""

    name: str
    effects: tuple[str, ...]

    @property
    def left_out(self) -> str:
        """The effect that is missing of all; empty in other sets."""
        return self.name.removeprefix(f"{ALL}-") if self.name.startswith(f"{ALL}-") else ""

    @property
    def added(self) -> str:
        """The effect that the scene's own has not; empty in other sets."""
        return self.name.removeprefix(f"{OWN}+") if self.name.startswith(f"{OWN}+") else ""

    @property
    def is_loaded(self) -> bool:
        """By an effect that moves the muscle: its outcomes are those of another experiment."""
        return self.added in LOADS

    def options(self, of_scene: tuple[str, ...]) -> list[str]:
        """Of `musclebench run`, for a scene that has these effects."""
        added = [word for name in self.effects if name not in of_scene for word in ("--effect", name)]
        return added + [word for name in of_scene if name not in self.effects for word in ("--no-effect", name)]


def effect_sets(own: tuple[str, ...], known: tuple[str, ...]) -> list[EffectSet]:
    """`known`: all of the program, in its order."""
    known = tuple(name for name in known if name in own or name not in OF_TABLES)
    every = tuple(name for name in known if name in own or name not in LOADS)
    sets = [EffectSet(OWN, tuple(name for name in known if name in own)), EffectSet(ALL, every)]
    sets += [EffectSet(f"{ALL}-{gone}", tuple(name for name in every if name != gone))
             for gone in every if gone not in KEPT]
    return sets + [EffectSet(f"{OWN}+{new}", tuple(name for name in known if name in own or name == new))
                   for new in known if new not in own]
