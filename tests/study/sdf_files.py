"""Small SDF files, written piece by piece."""

import gzip
from pathlib import Path

import numpy as np

START, GOAL = np.array([-5.0, 0.0]), np.array([5.0, 0.0])

CYLINDER = "<cylinder><radius>0.2</radius><length>1</length></cylinder>"
BOX = "<box><size>2 1 0.5</size></box>"
SPHERE = "<sphere><radius>0.3</radius></sphere>"
GROUND = "<model name='ground'><link name='l'>{}</link></model>".format(
    "<collision name='c'><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>"
)


def pose(text: str) -> str:
    return f"<pose frame=''>{text}</pose>" if text else ""


def model(shape: str, name: str = "thing", at: str = "", link_at: str = "", collision_at: str = "") -> str:
    """A model with one link that holds the shape twice, as what collides and as what is seen."""
    geometry = f"<geometry>{shape}</geometry>"
    return (
        f"<model name='{name}'><static>1</static>{pose(at)}\n<link name='link'>{pose(link_at)}\n"
        f"<collision name='c'>{pose(collision_at)}\n{geometry}</collision>\n<visual name='v'>{geometry}</visual>"
        "</link></model>\n"
    )


def state(name: str = "thing", at: str = "", link_at: str = "", scale: str = "1 1 1") -> str:
    link = f"<link name='link'>{pose(link_at)}</link>" if link_at else ""
    return (
        f"<state world_name='w'><model name='{name}'>{pose(at)}\n<scale>{scale}</scale>"
        f"{link}</model><light name='sun'>{pose('0 0 10 0 0 0')}</light></state>"
    )


def write(folder: Path, *pieces: str, name: str = "small.world", compressed: bool = False) -> Path:
    text = "<?xml version='1.0'?>\n<sdf version='1.6'><world name='w'>\n" + "".join(pieces) + "</world></sdf>"
    return write_text(folder, text, name, compressed)


def write_text(folder: Path, text: str, name: str = "small.world", compressed: bool = False) -> Path:
    path = folder / name
    path.write_bytes(gzip.compress(text.encode()) if compressed else text.encode())
    return path
