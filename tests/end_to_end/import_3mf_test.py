#!/usr/bin/env python3
"""tandem-import of 3MF: an assembly with a known answer, what is refused, damaged files, hostile ones.

    python3 tests/end_to_end/import_3mf_test.py --bin build/release/bin
"""
import collections
import io
import math
import pathlib
import random
import resource
import subprocess
import tempfile
import zipfile

from check_command import binaries_of_command_line, expect, report
from import_test import Importer, check_links, codes, ended_well, extent, refused

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIAL = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
OPC = "http://schemas.openxmlformats.org/package/2006/"
TYPES = (f'<Types xmlns="{OPC}content-types">'
         f'<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
         '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
         '</Types>')
RELATIONS = (f'<Relationships xmlns="{OPC}relationships"><Relationship Target="/3D/3dmodel.model" Id="r0" '
             'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')

POINTS = ((0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10))
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))

BLUE = 'pid="2" p1="0"'


def mesh(points=POINTS, faces=FACES, looks=()):
    """`looks` has a triangle's further attributes, in the order of the faces."""
    vertices = "".join('<vertex x="%s" y="%s" z="%s"/>' % tuple(p) for p in points)
    looks = list(looks) + [""] * (len(faces) - len(looks))
    triangles = "".join('<triangle v1="%d" v2="%d" v3="%d" %s/>' % (*f, look)
                        for f, look in zip(faces, looks))
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def components(*placed):
    return "<components>" + "".join(
        f'<component objectid="{number}"' + (f' transform="{place}"' if place else "") + "/>"
        for number, place in placed) + "</components>"


def model(resources, build, unit="millimeter"):
    return (f'<?xml version="1.0" encoding="UTF-8"?><model unit="{unit}" xml:lang="en-US" xmlns="{CORE}" '
            f'xmlns:m="{MATERIAL}"><resources>{resources}</resources><build>{build}</build></model>')


def package(text, **others):
    """The bytes of a package with that model."""
    parts = {"[Content_Types].xml": TYPES, "_rels/.rels": RELATIONS, "3D/3dmodel.model": text, **others}
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return out.getvalue()


def assembly(unit="millimeter"):
    """A frame of a plate and two pins, built twice, the second time turned a quarter about z."""
    resources = (
        '<basematerials id="1"><base name="Steel" displaycolor="#FF0000"/>'
        '<base name="Brass" displaycolor="#FFFF00FF"/></basematerials>'
        '<m:colorgroup id="2"><m:color color="#0000FF"/></m:colorgroup>'
        f'<object id="3" name="pin" type="model" pid="1" pindex="0">{mesh()}</object>'
        f'<object id="4" name="plate" type="model" pid="1" pindex="1">'
        f'{mesh(looks=["", "", BLUE])}'
        '</object>'
        f'<object id="5" type="support">{mesh()}</object>'
        '<object id="6" name="frame" type="model">'
        f'{components((4, ""), (3, "1 0 0 0 1 0 0 0 1 20 0 0"), (3, "2 0 0 0 2 0 0 0 2 0 30 0"), (5, ""))}'
        '</object>')
    build = ('<item objectid="6" partnumber="A-1"/>'
             '<item objectid="6" transform="0 1 0 -1 0 0 0 0 1 100 0 0"/>')
    return package(model(resources, build, unit))


def written(importer, name, data):
    path = importer.folder / name
    path.write_bytes(data)
    return path


def world_matrices(scene):
    """The matrix of each node in the world as rows, by the node's index."""
    worlds = {}

    def walk(index, above):
        node = scene["nodes"][index]
        flat = node.get("matrix", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
        own = [[flat[4 * c + r] for c in range(4)] for r in range(4)]
        worlds[index] = [[sum(above[r][k] * own[k][c] for k in range(4)) for c in range(4)] for r in range(4)]
        for child in node.get("children", []):
            walk(child, worlds[index])

    for top in scene["scenes"][0]["nodes"]:
        walk(top, [[float(r == c) for c in range(4)] for r in range(4)])
    return worlds


def check_assembly(importer):
    told, scene = importer.scene(written(importer, "frame.3mf", assembly()))
    expect((told["parts"], told["meshes"], told["unit"]) == (6, 2, "mm"), f"assembly: {told}")
    expect(codes(told) == {"support-structures": 2}, f"assembly: {told['findings']}")
    names = [node.get("name") for node in scene["nodes"]]
    expect(names == ["frame", "plate", "pin", "pin"] * 2, f"assembly: {names}")
    pins = [node for node in scene["nodes"] if node["name"] == "pin"]
    expect(len({pin["mesh"] for pin in pins}) == 1, "assembly: the pins share no mesh")
    expect(pins[0]["extras"]["cad"]["material"] == "Steel", f"assembly: {pins[0]}")
    colours = {name: [scene["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorFactor"][:3]
                      for primitive in scene["meshes"][node["mesh"]]["primitives"]]
               for name in ("pin", "plate") for node in scene["nodes"] if node["name"] == name}
    expect(colours["pin"] == [[1, 0, 0]], f"assembly: {colours}")
    expect(sorted(colours["plate"]) == [[0, 0, 1], [1, 1, 0]], f"assembly: {colours}")
    # Of the second frame: x becomes y, y becomes -x, 100 along x; then the file's z is up.
    expected = {"plate": (0.1, 0, 0), "pin": (0.1, 0, -0.02), "large": (0.07, 0, 0)}
    worlds = world_matrices(scene)
    for index, key in ((5, "plate"), (6, "pin"), (7, "large")):
        place = [worlds[index][row][3] for row in range(3)]
        expect(math.dist(place, expected[key]) < 1e-7, f"assembly: {key} stands at {place}")
    top = [sum(worlds[7][row][k] * (0, 0, 0.01, 1)[k] for k in range(4)) for row in range(3)]
    expect(math.dist(top, (0.07, 0.02, 0)) < 1e-7, f"assembly: the large pin points to {top}")
    told, scene = importer.scene(importer.folder / "frame.3mf", "--y-up")
    place = [row[3] for row in world_matrices(scene)[6]][:3]
    expect(math.dist(place, (0.1, 0.02, 0)) < 1e-7, f"assembly with --y-up: the pin stands at {place}")


def check_units(importer):
    importer.npm = None  # the validator has seen these meshes
    for unit, metres in (("micron", 1e-6), ("centimeter", 1e-2), ("inch", 0.0254), ("meter", 1.0)):
        told, scene = importer.scene(written(importer, "frame.3mf", assembly(unit)))
        longest = max(max(high) for high in extent(scene))
        expect(abs(longest / (10 * metres) - 1) < 1e-6, f"{unit}: {longest} m")
        expect(("unit-doubt" in codes(told)) == (unit in ("micron", "meter")), f"{unit}: {told['findings']}")
    told, scene = importer.scene(importer.folder / "frame.3mf", "--units", "mm")
    expect(told["unit"] == "mm" and max(max(high) for high in extent(scene)) < 0.0101, f"--units: {told}")


def check_oddities(importer):
    """What other programs write: nothing built, no names, triangles without area, shearing places."""
    told, scene = importer.scene(written(importer, "bare.3mf", package(model(
        f'<object id="1">{mesh()}</object><object id="2">{components((1, ""))}</object>', ""))))
    expect("nothing-built" in codes(told) and told["parts"] == 1, f"nothing built: {told}")
    expect({node["name"] for node in scene["nodes"]} == {"bare"}, f"no names: {scene['nodes']}")
    flat = mesh(POINTS + ((10, 0, 0),), FACES + ((1, 2, 4),))
    told, _ = importer.scene(written(importer, "parsec.3mf", assembly("parsec")))
    expect(told["unit"] == "mm" and "reader-warnings" in codes(told), f"an unknown unit: {told}")
    told, _ = importer.scene(written(importer, "flat.3mf", package(model(
        f'<object id="1">{flat}</object>', '<item objectid="1"/>'))))
    expect(codes(told) == {"unusable-triangles": 1} and told["triangles"] == 4, f"without area: {told}")
    told, scene = importer.scene(written(importer, "sheared.3mf", package(model(
        f'<object id="1">{mesh()}</object>'
        f'<object id="2">{components((1, "1 0 0 0 1 0 0 0 1 5 0 0"))}</object>',
        '<item objectid="1"/><item objectid="2" transform="1 0 0 1 1 0 0 0 1 0 0 0"/>'))))
    expect((told["parts"], told["meshes"]) == (2, 2), f"sheared: {told}")
    expect(codes(told) == {"sheared-instances": 1}, f"sheared: {told['findings']}")
    widest = max(high[0] for high in extent(scene))
    expect(abs(widest - 0.015) < 1e-7, f"sheared: {widest} m wide")


def nested(depth, width):
    """Objects of `width` of the one before, down to a mesh."""
    objects = f'<object id="1">{mesh()}</object>' + "".join(
        f'<object id="{number}">{components(*[(number - 1, "")] * width)}</object>'
        for number in range(2, depth + 2))
    return package(model(objects, f'<item objectid="{depth + 1}"/>'))


def check_refusals(importer):
    (importer.folder / "out.glb").unlink(missing_ok=True)
    good = assembly()
    one = f'<object id="1">{mesh()}</object>'
    item = '<item objectid="1"/>'
    whole = {
        "empty": b"", "text": b"hello\n", "half": good[:len(good) // 2], "head": good[:10],
        "no_model": package("").replace(b"3dmodel", b"3dmodal"),
        "no_xml": package("hello"), "cut_xml": package(model(one, item)[:300]),
        "itself": package(model(f'<object id="1">{components((1, ""))}</object>', item)),
        "circle": package(model(f'<object id="1">{components((2, ""))}</object>'
                                f'<object id="2">{components((1, ""))}</object>', item)),
        "absent": package(model(one, '<item objectid="7"/>')),
        "no_triangle": package(model(f'<object id="1">{mesh(faces=())}</object>', item)),
        "all_flat": package(model(f'<object id="1">{mesh(((0, 0, 0), (0, 0, 0), (0, 0, 0)), ((0, 1, 2),))}'
                                  '</object>', item)),
        "corner_absent": package(model(f'<object id="1">{mesh(faces=((0, 1, 9),))}</object>', item)),
        "not_a_number": package(model(f'<object id="1">{mesh((("nan", 0, 0),) + POINTS[1:])}</object>',
                                      '<item objectid="1" transform="nan 0 0 0 1 0 0 0 1 0 0 0"/>')),
        "no_volume": package(model(one, '<item objectid="1" transform="0 0 0 0 0 0 0 0 0 0 0 0"/>')),
        "deep": nested(300, 1), "many": nested(19, 2),
    }
    for name, data in whole.items():
        refused(importer, written(importer, name + ".3mf", data), name + ".3mf", "--limit-seconds", "20")
    # lib3mf itself walks through all of them.
    refused(importer, written(importer, "endless.3mf", nested(40, 2)), "--limit-seconds",
            "--limit-seconds", "1")


def bomb(importer, name, before, repeated, times):
    """A package whose model goes on and on, written piece by piece: a fork of this process is to be small."""
    path = importer.folder / name
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("[Content_Types].xml", TYPES)
        archive.writestr("_rels/.rels", RELATIONS)
        with archive.open("3D/3dmodel.model", "w") as out:
            out.write((model("", "").split("<resources>")[0] + before).encode())
            for _ in range(times):
                out.write(repeated.encode())
    return path


def check_bombs(importer):
    """200 MB of nothing, and points without end, in a file of 2 MB: within the limit of memory."""
    blank = bomb(importer, "blank.3mf", "<resources>", " " * 100000, 2000)
    endless = bomb(importer, "points.3mf", '<resources><object id="1"><mesh><vertices>',
                   '<vertex x="0" y="0" z="0"/>' * 4000, 2000)
    for path in (blank, endless):
        expect(path.stat().st_size < 2 << 20, f"{path.name}: {path.stat().st_size} bytes")
        refused(importer, path, path.name, "--limit-memory", "256", "--limit-seconds", "20")
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024
    expect(most < 300 << 20, f"hostile files: {most >> 20} MiB were used")


def check_damage(importer):
    """Half of them within the package, half of the model in a sound package."""
    ends = collections.Counter()
    source = assembly()
    with zipfile.ZipFile(io.BytesIO(source)) as archive:
        text = archive.read("3D/3dmodel.model")
    for seed in range(100):
        draw, data = random.Random(seed), bytearray(text if seed % 2 else source)
        for _ in range(draw.choice((1, 3, 30))):
            data[draw.randrange(len(data))] = draw.randrange(256)
        if seed % 10 == 9:
            data = data[:draw.randrange(len(data))]
        file = written(importer, "damaged.3mf", package(bytes(data)) if seed % 2 else bytes(data))
        done = ended_well(importer, file, seed)
        ends[done.returncode] += 1
    expect(ends[0] > 0 and ends[2] > 0, f"damage that does nothing, or all: {ends}")
    print("damaged files:", dict(ends))


def check_server(importer):
    file = written(importer, "frame.3mf", assembly())
    done = subprocess.run([importer.binaries / "tandem-server", file, "--listen", "127.0.0.1:0", "--duration",
                           "0.2", "--movable", "all", "--data", importer.folder / "data"],
                          capture_output=True, text=True,
                          env={"XDG_CACHE_HOME": str(importer.folder / "cache")})
    expect(done.returncode == 0 and "6 parts (6 movable)" in done.stderr, f"server: {done.stderr}")


def main():
    binaries = binaries_of_command_line()
    with tempfile.TemporaryDirectory() as folder:
        importer = Importer(binaries, pathlib.Path(folder))
        check_links(importer, "lib3MF")
        for check in (check_assembly, check_units, check_oddities, check_refusals, check_bombs,
                      check_damage, check_server):
            check(importer)
    return report()


if __name__ == "__main__":
    raise SystemExit(main())
