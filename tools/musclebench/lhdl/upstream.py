"""The upstream files: which repository and commit, what each file is, and the digest that pins its bytes."""

import hashlib
from pathlib import Path

SOURCES = [
    {
        "id": "3d-muscles",
        "repository": "https://github.com/modenaxe/3d-muscles",
        "commit": "e30f2ff0feeec7b970392d0a29784d43b5dbfb0c",
    },
    {
        "id": "muscle-deformation-PBD",
        "repository": "https://github.com/cervenkam/muscle-deformation-PBD",
        "commit": "66cce66944a8e81cb9bbc82f845bd45beccf0d9b",
    },
]

_HIP = "3d-muscles/_LHDL_hip_r_dataset/_LHDL_hip_r_dataset"
_MOTION = "3d-muscles/a_MSK_model/b_kinematics"
_PBD = "muscle-deformation-PBD/data"

PSOAS = f"{_HIP}.415.vtk"
SACRUM = f"{_HIP}.523.vtk"
HIP_BONE_LEFT = f"{_HIP}.524.vtk"
HIP_BONE_RIGHT = f"{_HIP}.525.vtk"
LANDMARKS = f"{_HIP}.nms"
OPENSIM_MODEL = "3d-muscles/a_MSK_model/a_MSK_model/LHDL_hip_r.osim"
MOTIONS = {name: f"{_MOTION}/{name}.mot" for name in ("hip_flexion", "hip_adduction", "hip_rotation")}
FEMUR = f"{_PBD}/bone1_s1.vtk"
FIBRES = f"{_PBD}/fibre0_s1.vtk"
GLUTEUS_MAXIMUS = f"{_PBD}/muscle0_s1.vtk"
GLUTEUS_MEDIUS = f"{_PBD}/muscle1_s1.vtk"
ILIACUS = f"{_PBD}/muscle2_s1.vtk"
ADDUCTOR_BREVIS = f"{_PBD}/muscle3_s1.vtk"

SHA256 = {
    PSOAS: "6195808ce56b880c0ae49074b2bb4156b07e7e76457dea4c8d9a32845d04571a",
    SACRUM: "fce41ad7212823b515761373e6687bc9c85bc0007570c39d1ad821d62635184d",
    HIP_BONE_LEFT: "13546d7ffa2c59ab164df29e526f2e11e0f92726b43b6966ff1e1dd81cdb1e5b",
    HIP_BONE_RIGHT: "d23ffb3e6f6f85cc9766f2fe93e7b53904560792d8d5036ad9417ccfa461e2e6",
    LANDMARKS: "e2d87fc91a8ddc706ce6d3e18f609a066e39c42575a598c8c21c0eb3b1c33f09",
    OPENSIM_MODEL: "18c6d750bfccb9f9ec16324bef866bb9aab247d70e45ada12f570c964cb2edcc",
    MOTIONS["hip_adduction"]: "b4bd9a29829059ba50562a03eba3bafbb6879ff46195356ab55fa28e7ddf0386",
    MOTIONS["hip_flexion"]: "ccd11f1dd69dab2643038e437158c30193151de7d423f6e4e7dd99613e884eaa",
    MOTIONS["hip_rotation"]: "f3927e00baeb4243e5943c3e51e212d00d4bc0d0fdd0cff919ca169de93664a4",
    FEMUR: "386e83e82dcbcb0b4136a696dbc1e39e26df88a0f35ba997f763a32b859c7587",
    FIBRES: "74287d5a3f73f0e778290b96dcc9465c5bbed2734cf0e81f6e2386bb36387e25",
    GLUTEUS_MAXIMUS: "3ac9b95faed69d7fa3a99dd475c38d4acf41b31b5bc9ccd028ba63ad7b14d0d2",
    GLUTEUS_MEDIUS: "1be1845bdca63c0c14bf75aa8b27afadd190730bf394892437c8e3a9e70cf0d8",
    ILIACUS: "6e1f02a47db0015b0950d1dd1857fc17f09a911cf35be408b176e7c6490f4033",
    ADDUCTOR_BREVIS: "49c448ce3af73046884f041ea65ca3d557b847796e8dd0ffb175012fa10f43fa",
}


class ImportProblem(Exception):
    """Bad input; the message is one line with the location, the problem and the cure."""


def verify(upstream_dir: Path) -> None:
    """Raises ImportProblem unless every file is there with exactly the published bytes."""
    for name, expected in SHA256.items():
        path = upstream_dir / name
        if not path.is_file():
            raise ImportProblem(
                f"{path}: not there; clone 3d-muscles and muscle-deformation-PBD into the upstream folder"
            )
        if hashlib.sha256(path.read_bytes()).hexdigest() != expected:
            source = next(s for s in SOURCES if name.startswith(s["id"]))
            raise ImportProblem(
                f"{path}: its SHA-256 is not the published one; check out commit {source['commit'][:12]} of "
                f"{source['repository']}"
            )
