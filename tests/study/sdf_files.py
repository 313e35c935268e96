"""SDF files made by hand."""

import gzip

CYLINDER = "<cylinder><radius>0.2</radius><length>1</length></cylinder>"


def model(shape, name="thing", at="", link_at="", collision_at=""):
    poses = [f"<pose frame=''>{text}</pose>" if text else "" for text in (at, link_at, collision_at)]
    geometry = f"<geometry>{shape}</geometry>"
    return (
        f"<model name='{name}'>{poses[0]}\n<link name='link'>{poses[1]}\n<collision name='c'>{poses[2]}\n{geometry}"
        f"</collision>\n<visual name='v'>{geometry}</visual></link></model>\n"
    )


def write(folder, *pieces, name="small.world", head=""):
    text = f"<?xml version='1.0'?>\n{head}<sdf version='1.6'><world name='w'>\n{''.join(pieces)}</world></sdf>"
    (folder / name).write_bytes(gzip.compress(text.encode()) if name.endswith("gz") else text.encode())
    return folder / name
