"""Files as other programs and people write them: what is valid is read, and what cannot be used is said."""

import numpy as np
import pytest
from conftest import run
from mesh import find_model, read_mesh
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade
from runs import warnings
from sources import faulty, write

TEXT = """#usda {version}
(
    defaultPrim = "G"{metadata}
)

def Xform "G"
{{
    def Mesh "m"
    {{
{extra}
        int[] faceVertexCounts = [4, 4]
        int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
        point3f[] points = [{points}]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1), (1, 0), (2, 0), (2, 1), (1, 1)] (
            interpolation = "faceVarying"
        )
    }}
}}
"""
POINTS = [(0, 0, 0), (0.5, 0, 0), (2, 0, 0), (0, 0.5, 0), (1, 1, 0), (2, 1, 0)]
USUAL = ", ".join(str(p) for p in POINTS)


def text(path, *, version="1.0", metadata="", extra="", points=USUAL):
    path.write_text(TEXT.format(version=version, metadata=metadata, extra=extra, points=points))
    return path


@pytest.mark.parametrize("words", [
    {"points": USUAL.replace("0.5", ".5").replace("(2, ", "(2., ")},
    {"points": USUAL + " // the corners\n        "},
    {"points": "/* six */ " + USUAL},
    {"version": "1.1"},
    {"extra": "        config token note = \"a\"\n        bool doubleSided = yes"},
    {"extra": "        // a comment with a \" in it"},
], ids=["dots", "slashes", "block", "version", "old words", "quote"])  # fmt: skip
def test_texts_that_open_usd_reads_are_read(build, tmp_path, words):
    path = text(tmp_path / "a.usda", **words)
    stage = Usd.Stage.Open(str(path))
    assert np.allclose(UsdGeom.Mesh(stage.GetPrimAtPath("/G/m")).GetPointsAttr().Get(), POINTS)
    product = build(path, "--set", "render.level=0")
    assert np.array_equal(read_mesh(product.stage.GetPrimAtPath("/G/render")).points, np.float32(POINTS))


DOC = r"""
    doc = '''a\''' b'''"""
QUOTES = r'''
    customLayerData = {
        string quotes = """two \"quotes\" and \"""  one"""
    }'''
MIRRORED = """            active = 1
            symmetryFunction = mirror
            symmetryArguments = {
                string axis = "x}"
            }
            hidden = 0
"""


def test_flags_are_numbers_too_and_old_metadata_are_told(build, tmp_path):
    path = text(tmp_path / "a.usda", metadata=DOC + QUOTES)
    path.write_text(path.read_text().replace('def Mesh "m"\n', f'def Mesh "m" (\n{MIRRORED}        )\n'))
    layer = Sdf.Layer.FindOrOpen(str(path))
    product = build(path, "--flatten")
    written = product.stage.GetRootLayer()
    assert layer.documentation == "a''' b" and written.documentation.startswith(layer.documentation)
    assert written.customLayerData["quotes"] == layer.customLayerData["quotes"]
    mesh = product.stage.GetPrimAtPath("/G/m")
    assert mesh.IsActive() and mesh.GetMetadata("hidden") is False
    (told,) = [warning for warning in product.warnings if "symmetry" in warning]
    assert "symmetryArguments, symmetryFunction" in told and str(path) in told


def test_what_only_newer_versions_have_is_not_called_damaged(usdtailor, tmp_path):
    extra = '        def GeomSubset "s"\n        {\n            int[] indices = edit [append 5]\n        }'
    done = run(usdtailor, "check", text(tmp_path / "a.usda", extra=extra))
    assert done.returncode == 1 and "error[not-supported]" in done.stderr and "damaged" not in done.stderr


def test_a_byte_order_mark_is_named(usdtailor, tmp_path):
    path = text(tmp_path / "a.usda")
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    done = run(usdtailor, "check", path)
    assert done.returncode == 1 and "byte order mark" in done.stderr


def test_a_name_of_very_many_parts_is_an_error(usdtailor, tmp_path):
    extra = f"        custom string tailor:seam:{'a:' * 20000}edges = \"uvSeams\""
    for command in ("check", "info", "build"):
        args = ["-o", tmp_path / "out.usda"] if command == "build" else []
        done = run(usdtailor, command, text(tmp_path / "a.usda", extra=extra), *args)
        assert done.returncode == 1 and "error[recipe-attribute]" in done.stderr and len(done.stderr) < 2000


@pytest.mark.parametrize("above", [True, False])
def test_a_garment_of_the_purpose_render_stays_one(build, tmp_path, above):
    def change(mesh):
        prim = mesh.GetPrim().GetParent() if above else mesh.GetPrim()
        UsdGeom.Imageable(prim).CreatePurposeAttr("render")

    product = build(faulty(change)(tmp_path / "a.usda"))
    purpose = lambda name: UsdGeom.Imageable(product.prim(name)).ComputePurpose()
    assert [purpose(name) for name in ("model", "sim", "render")] == ["guide", "guide", "render"]


def costume(path):
    """A shirt with what cannot be a garment beside it."""

    def change(mesh):
        stage = mesh.GetPrim().GetStage()
        UsdGeom.Mesh.Define(stage, "/Coat/empty").CreateFaceVertexCountsAttr([])
        button = UsdGeom.Mesh.Define(stage, "/Coat/buttons/protos/button")
        button.CreatePointsAttr([(0, 0, 5), (1, 0, 5), (1, 1, 5), (0, 1, 5)])
        button.CreateFaceVertexCountsAttr([4])
        button.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
        instancer = UsdGeom.PointInstancer.Define(stage, "/Coat/buttons")
        instancer.CreatePrototypesRel().AddTarget("/Coat/buttons/protos/button")
        instancer.CreatePositionsAttr([(0, 0, 0), (1, 0, 0)])
        instancer.CreateProtoIndicesAttr([0, 0])

    return faulty(change)(path)


def test_what_cannot_be_a_garment_is_left_out_and_said(build, tmp_path):
    product = build(costume(tmp_path / "a.usda"), "--all")
    told = [message for code, message in warnings(product) if code == "not-carried"]
    assert any("/Coat/empty" in m for m in told) and any("PointInstancer" in m for m in told), told
    names = [p.GetName() for p in product.stage.Traverse() if p.IsA(UsdGeom.Mesh)]
    assert sorted(names) == ["button", "empty", "model", "render", "sim"]


def test_instances_of_a_named_prototype_stay(usdtailor, tmp_path):
    out = tmp_path / "out.usda"
    done = run(usdtailor, "build", costume(tmp_path / "a.usda"), "--prim", "/Coat/buttons/protos/button", "-o", out)
    assert done.returncode == 0 and "the instances of" in done.stderr
    stage = Usd.Stage.Open(str(out))
    button = UsdGeom.Imageable(stage.GetPrimAtPath("/Coat/buttons/protos/button"))
    assert button.ComputePurpose() == "default"


def test_a_variant_without_the_mesh_is_skipped(usdtailor, tmp_path):
    path, out = tmp_path / "a.usda", tmp_path / "out.usda"
    stage = Usd.Stage.CreateNew(str(path))
    root = UsdGeom.Xform.Define(stage, "/G").GetPrim()
    stage.SetDefaultPrim(root)
    look = root.GetVariantSets().AddVariantSet("look")
    for name in ("off", "on"):
        look.AddVariant(name)
    look.SetVariantSelection("on")
    with look.GetVariantEditContext():
        mesh = UsdGeom.Mesh.Define(stage, "/G/m")
        mesh.CreatePointsAttr(POINTS)
        mesh.CreateFaceVertexCountsAttr([4, 4])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 4, 3, 1, 2, 5, 4])
    stage.GetRootLayer().Save()
    done = run(usdtailor, "build", path, "--variants", "look", "-o", out)
    assert done.returncode == 0 and "{look=off}" in done.stderr, done.stderr
    made = Usd.Stage.Open(str(out))
    assert made.GetPrimAtPath("/G/render")
    made.GetPrimAtPath("/G").GetVariantSet("look").SetVariantSelection("off")
    assert not made.GetPrimAtPath("/G/render")


def test_no_number_that_is_written_is_infinite(build, tmp_path):
    def change(mesh):
        primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        values = list(primvar.Get())
        values[3] = Gf.Vec2f(1e19, -1e30)
        primvar.Set(values)

    product = build(faulty(change)(tmp_path / "a.usda"))
    assert any(code == "no-uv-set" and "beyond 1e15" in message for code, message in warnings(product))
    for name in ("sim", "render"):
        for attribute in product.prim(name).GetAttributes():
            value = attribute.Get()
            if "[]" in str(attribute.GetTypeName()) and value is not None and attribute.GetTypeName().scalarType.cppTypeName.startswith(("GfVec", "float")):
                assert np.isfinite(np.array(value)).all(), attribute.GetPath()


def test_check_finds_names_that_a_build_refuses(usdtailor, tmp_path):
    path = faulty(lambda mesh: UsdGeom.Scope.Define(mesh.GetPrim().GetStage(), "/Coat/render"))(tmp_path / "a.usda")
    for args in (["check", path], ["build", path, "-o", tmp_path / "out.usda"]):
        done = run(usdtailor, *args)
        assert done.returncode == 1 and "error[name-taken]: /Coat/render" in done.stderr, args


def two_panels(path, a="", b="", of_b=""):
    """Two quads, each below a prim of its own, that meet along an edge."""

    def panel(name, binding, x, extra=""):
        points = ", ".join(str((x + i % 2, i // 2, 0)) for i in range(4))
        return f"""
    def Xform "{name}" (prepend apiSchemas = ["MaterialBindingAPI"])
    {{
        {binding}
        def Mesh "{name}_mesh" (prepend apiSchemas = ["MaterialBindingAPI"])
        {{
            {extra}
            int[] faceVertexCounts = [4]
            int[] faceVertexIndices = [0, 1, 3, 2]
            point3f[] points = [{points}]
        }}
    }}"""

    materials = "".join(f'    def Material "{m}" {{ }}\n' for m in "MNO")
    path.write_text(f'#usda 1.0\n(\n    defaultPrim = "G"\n)\ndef Xform "G"\n{{\n{materials}{panel("a", a, 0)}{panel("b", b, 1, of_b)}\n}}\n')
    return path


@pytest.mark.parametrize(("words", "expected"), [
    ({"a": "rel material:binding = </G/M>"}, ["M", None]),
    ({"a": "rel material:binding = </G/M>", "b": "rel material:binding = </G/N>"}, ["M", "N"]),
    ({"a": "rel material:binding = </G/M>", "b": "rel material:binding = </G/M>"}, ["M", "M"]),
    ({"b": "rel material:binding = </G/N>", "of_b": "rel material:binding = </G/O>"}, [None, "O"]),
    ({"b": 'rel material:binding = </G/N> (bindMaterialAs = "strongerThanDescendants")', "of_b": "rel material:binding = </G/O>"}, [None, "N"]),
], ids=["one", "two", "same", "own", "stronger"])  # fmt: skip
def test_panels_keep_the_materials_of_prims_above_them(build, tmp_path, words, expected):
    product = build(two_panels(tmp_path / "a.usda", **words), "--all", "--set", "render.level=0")
    mesh = UsdGeom.Mesh(product.stage.GetPrimAtPath("/G/render"))
    bound = lambda prim: UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPath().name or None
    of_faces = [bound(mesh.GetPrim())] * 2
    for subset in UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets():
        for face in subset.GetIndicesAttr().Get():
            of_faces[face] = bound(subset.GetPrim())
    assert of_faces == expected


@pytest.mark.parametrize("words", [
    'float[] primvars:wet = [1, 2, 3] (interpolation = "vertex")',
    'normal3f[] primvars:normals = [(0, 0, 1)] (interpolation = "faceVarying")\nint[] primvars:normals:indices = [0, 0, 0, 7]',
], ids=["weights", "normals"])  # fmt: skip
def test_panels_are_sewn_without_primvars_with_faults(build, tmp_path, words):
    product = build(two_panels(tmp_path / "a.usda", of_b=words), "--all", "--set", "render.level=0")
    assert len(UsdGeom.Mesh(product.stage.GetPrimAtPath("/G/render")).GetPointsAttr().Get()) == 6
    assert any("/G/b/b_mesh.primvars:" in message for _, message in warnings(product))


def test_an_element_size_that_does_not_fit_is_left_out(build, tmp_path):
    """Exports of Arnold have the number of values there."""

    def change(mesh):
        primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        primvar.SetElementSize(len(primvar.Get()))

    plain, product = build(write(tmp_path / "plain.usda", seam_column=2), stem="built_plain"), build(faulty(change)(tmp_path / "a.usda"), stem="changed")
    assert any(code == "not-carried" and "elementSize" in message for code, message in warnings(product))
    for name in ("sim", "render"):
        of = [UsdGeom.PrimvarsAPI(p.prim(name)).GetPrimvar("st") for p in (plain, product)]
        assert np.array_equal(*(primvar.ComputeFlattened() for primvar in of)) and of[1].GetElementSize() == 1


def test_an_empty_mesh_beside_a_garment_is_left_out(build, tmp_path):
    path = two_panels(tmp_path / "a.usda")
    path.write_text(path.read_text().rstrip().removesuffix("}") + '    def Mesh "placeholder" { }\n}\n')
    product = build(path, "--all")
    assert any(code == "not-carried" and "/G/placeholder" in message for code, message in warnings(product))


def test_meshes_that_are_no_garments_are_named_with_a_remedy(usdtailor, tmp_path):
    path = two_panels(tmp_path / "a.usda")
    inside = path.read_text().replace('def Xform "G"', 'def PointInstancer "G"')
    path.write_text(inside)
    for args in ([], ["--all"]):
        done = run(usdtailor, "check", path, *args)
        assert done.returncode == 1 and "PointInstancer" in done.stderr and "name" in done.stderr and "--prim" in done.stderr, done.stderr
        assert "products of usd-tailor" not in done.stderr
    assert run(usdtailor, "build", path, "--prim", "/G/a/a_mesh", "-o", tmp_path / "o.usda").returncode == 0


def test_a_rule_that_the_scheme_has_no_use_for_is_not_read(build, tmp_path):
    path = text(tmp_path / "a.usda", extra='        uniform token subdivisionScheme = "none"\n        token triangleSubdivisionRule = "none"')
    build(path, "--set", "render.level=0")


def test_numbers_without_a_comma_are_refused_as_open_usd_refuses_them(usdtailor, tmp_path):
    path = text(tmp_path / "a.usda", points=USUAL.replace("(1, 1, 0)", "(1 1, 0)"))
    with pytest.raises(Tf.ErrorException):
        Usd.Stage.Open(str(path))
    line = 1 + path.read_text()[: path.read_text().index("1 1")].count("\n")
    done = run(usdtailor, "build", path, "-o", tmp_path / "out.usda")
    assert done.returncode == 1 and f"line {line} has two numbers without a comma" in done.stderr
    assert not (tmp_path / "out.usda").exists()


@pytest.mark.parametrize("line", ["rel a = [</G>, </G/m>, </G>]", "float b.connect = [</G.a>, </G.a>]"], ids=["targets", "connections"])
def test_a_target_that_is_there_twice_is_refused_as_open_usd_refuses_it(usdtailor, tmp_path, line):
    path = text(tmp_path / "a.usda", extra=f"        {line}")
    with pytest.raises(Tf.ErrorException):
        Usd.Stage.Open(str(path))
    number = 1 + path.read_text()[: path.read_text().index(line)].count("\n")
    done = run(usdtailor, "build", path, "-o", tmp_path / "out.usda")
    assert done.returncode == 1 and f"line {number} has a path that its list has already" in done.stderr, done.stderr
    assert not (tmp_path / "out.usda").exists()


def test_a_prototype_beside_its_instancer_keeps_its_purpose(build, tmp_path):
    def change(mesh):
        instancer = UsdGeom.PointInstancer.Define(mesh.GetPrim().GetStage(), "/Crowd")
        instancer.CreatePrototypesRel().AddTarget(mesh.GetPrim().GetParent().GetPath())
        instancer.CreatePositionsAttr([(0, 0, 0), (9, 0, 0)])
        instancer.CreateProtoIndicesAttr([0, 0])

    source = faulty(change)(tmp_path / "a.usda")
    for args in ([], ["--prim", "/Coat/model"]):
        product = build(source, *args, stem=f"out{len(args)}")
        assert UsdGeom.Imageable(product.stage.GetPrimAtPath("/Coat/model")).ComputePurpose() == "default"
        assert any("/Crowd repeats it" in message for code, message in warnings(product) if code == "not-carried")


def test_crates_that_are_too_old_are_not_called_damaged(usdtailor, tmp_path):
    path = tmp_path / "a.usdc"
    path.write_bytes(b"PXR-USDC\0\0\1" + bytes(400))
    done = run(usdtailor, "check", path)
    assert done.returncode == 1 and "damaged" not in done.stderr, done.stderr


def test_a_package_inside_a_package_is_read(build, tmp_path):
    import zipfile

    def package(path, entries):
        with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as out:
            for name, data in entries:
                offset = out.fp.tell() + 30 + len(name)
                info = zipfile.ZipInfo(name)
                info.extra = b"\x86\x19" + (-(offset + 4) % 64).to_bytes(2, "little") + bytes(-(offset + 4) % 64)
                out.writestr(info, data)
        return path

    inner = package(tmp_path / "inner.usdz", [("a.usda", text(tmp_path / "a.usda", points=USUAL.replace("0.5", ".5")).read_bytes())])
    root = b'#usda 1.0\n(\n    defaultPrim = "G"\n)\ndef Xform "G" (prepend references = @./inner.usdz@)\n{\n}\n'
    for name, entries in {"referenced": [("root.usda", root), ("inner.usdz", inner.read_bytes())], "first": [("inner.usdz", inner.read_bytes())]}.items():
        outer = package(tmp_path / f"{name}.usdz", entries)
        if Usd.Stage.Open(str(outer)).GetPrimAtPath("/G/m"):
            product = build(outer, "--set", "render.level=0", "--flatten", stem=name)
            assert np.array_equal(read_mesh(product.stage.GetPrimAtPath("/G/render")).points, np.float32(POINTS)), name


@pytest.mark.skipif(not hasattr(Usd.Attribute, "SetSpline"), reason="splines are in newer versions of OpenUSD")
@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_an_animation_by_splines_is_told_where_it_is_lost(build, tmp_path, suffix):
    from pxr import Ts

    path = write(tmp_path / "a.usda")
    stage = Usd.Stage.Open(str(path))
    spline = Ts.Spline()
    for time, value in ((1, 0.0), (10, 5.0)):
        spline.SetKnot(Ts.Knot(time=time, value=value))
    op = UsdGeom.Xformable(find_model(stage)).AddTranslateXOp()
    op.GetAttr().SetSpline(spline)
    source = tmp_path / f"splined{suffix}"
    stage.GetRootLayer().Export(str(source))
    for args in ([], ["--flatten"]):
        product = build(source, *args, stem=f"out{len(args)}")
        assert any(code == "not-carried" and "spline" in message for code, message in warnings(product))
        # At no time are products elsewhere than where they were made.
        for time in (1, 10, 50):
            at = UsdGeom.Xformable(product.prim("render")).ComputeLocalToWorldTransform(time).ExtractTranslation()
            assert at[0] == 0, time


def test_a_word_of_the_format_is_not_written_as_metadata(usdtailor, tmp_path):
    """OpenUSD does not open such a file, and would not open the output."""
    path = tmp_path / "a.usda"
    path.write_text(text(path).read_text().replace('interpolation = "faceVarying"', 'interpolation = "faceVarying"\n            class = "vertex"'))
    out = tmp_path / "out.usda"
    assert run(usdtailor, "build", path, "-o", out, "--set", "render.level=0").returncode == 0
    assert Sdf.Layer.OpenAsAnonymous(str(out)).GetPrimAtPath("/G/render")
