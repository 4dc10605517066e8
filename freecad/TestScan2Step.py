"""Tests of the addon without a window: freecadcmd -M freecad -t TestScan2Step"""

import json
import os
import tempfile
import unittest

import FreeCAD
import Mesh
import numpy as np
import Part
import scan2step
from freecad.scan2step_wb import assembly, convert, deviation, feature, part

FIXTURES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "fixtures")


def fixture(name):
    return os.path.join(FIXTURES, name)


class Scans(unittest.TestCase):
    def setUp(self):
        self.document = FreeCAD.newDocument("scans")

    def tearDown(self):
        FreeCAD.closeDocument(self.document.Name)

    def scan(self, name):
        source = self.document.addObject("Mesh::Feature", "scan")
        source.Mesh = Mesh.Mesh(fixture(name))
        return source

    def converted(self, source, **options):
        values = {**convert.defaults(), **options}
        made = scan2step.convert(*convert.arrays(source), **convert.arguments(values))
        prepared = convert.Prepared(made, scan2step.__version__)
        return made, feature.apply(self.document, source, prepared, values)

    def test_a_mesh_becomes_a_face(self):
        source = self.scan("relief.ply")
        made, result = self.converted(source, tolerance=0.5)
        self.assertEqual(result.Shape.ShapeType, "Face")
        self.assertTrue(result.Shape.isValid())
        self.assertEqual(len(result.Shape.Wires), 3, "the outer boundary and two holes")
        self.assertTrue(result.ToleranceMet)
        self.assertAlmostEqual(result.Rms.Value, made.rms)
        self.assertEqual(len(result.Deviations), source.Mesh.CountPoints)
        self.assertFalse(result.Stale)

    def test_a_body_becomes_a_solid(self):
        made, result = self.converted(self.scan("ring.obj"))
        self.assertEqual(result.Shape.ShapeType, "Solid")
        self.assertTrue(result.Shape.isValid())
        self.assertAlmostEqual(result.Shape.Volume / made.volume, 1.0, 4)

    def test_a_part_has_its_bores(self):
        made, result = self.converted(self.scan("bracket.stl"))
        self.assertTrue(result.Shape.isValid())
        self.assertEqual(part.kinds(made.report), "7 planes, 5 cylinders, 2 cones, 1 torus")
        rows = part.cylinders(json.loads(result.Report))
        self.assertEqual(
            [texts[:3] for texts, _ in rows],
            [("round edge", "20", "x"), ("bore", "9", "x"), ("fillet", "8", "y"), ("bore", "2.75", "z"), ("bore", "2.75", "z")],
        )
        # The numbers of the faces are those of the shape.
        for row, (_, faces) in zip(made.cylinders(), rows):
            for face in faces:
                surface = result.Shape.Faces[face].Surface
                self.assertIsInstance(surface, Part.Cylinder)
                self.assertAlmostEqual(surface.Radius, row.radius, 6)
                off = surface.Center - FreeCAD.Vector(*row.at)
                self.assertLess(off.cross(surface.Axis).Length, 1e-6)
        notes = part.notes(made.report)
        self.assertIn("equal radius: 4, 5", notes)
        self.assertIn("coaxial: 1, 2", notes)
        self.assertTrue(any(note.startswith("moved within the rounding") for note in notes), notes)

    def test_a_scan_is_no_part(self):
        made, _ = self.converted(self.scan("relief.ply"), tolerance=0.5)
        self.assertFalse(part.is_exact(made.report))

    def test_a_cloud_becomes_a_face(self):
        import Points

        source = self.document.addObject("Points::Feature", "cloud")
        rows = scan2step.read(fixture("relief.xyz")).vertices
        source.Points = Points.Points([FreeCAD.Vector(*row) for row in rows])
        _, result = self.converted(source, shape="face", tolerance=0.6)
        self.assertEqual(result.Shape.ShapeType, "Face")

    def test_meshes_that_overlap_become_one_face(self):
        whole, twice = Mesh.Mesh(fixture("relief.ply")), Mesh.Mesh()
        box = whole.BoundBox
        points, triangles = whole.Topology
        for low, high in ((-1.0, 0.6), (0.4, 2.0)):
            share = [(p.x - box.XMin) / box.XLength for p in points]
            kept = [t for t in triangles if all(low <= share[k] <= high for k in t)]
            twice.addFacets([[points[k] for k in t] for t in kept])
        source = self.document.addObject("Mesh::Feature", "scan")
        source.Mesh = twice
        made, result = self.converted(source, points="alone", shape="face", tolerance=1.0)
        self.assertEqual(result.Shape.ShapeType, "Face")
        self.assertGreater(result.Shape.BoundBox.XLength, 0.95 * box.XLength)

    def test_changes_make_a_result_stale_and_never_convert(self):
        source = self.scan("relief.ply")
        _, result = self.converted(source, tolerance=0.5)
        before = result.Step
        result.Tolerance = 0.3
        self.document.recompute()
        self.assertTrue(result.Stale)
        self.assertEqual(result.Step, before)
        result.Tolerance = 0.5
        self.document.recompute()
        self.assertFalse(result.Stale)
        mesh = source.Mesh.copy()
        mesh.translate(1.0, 0.0, 0.0)
        source.Mesh = mesh
        self.document.recompute()
        self.assertTrue(result.Stale)

    def test_a_moved_inner_point_makes_a_result_stale(self):
        import Points

        rows = scan2step.read(fixture("relief.xyz")).vertices
        moved = rows.copy()
        inner = np.argmin(np.linalg.norm(rows - rows.mean(axis=0), axis=1))
        moved[inner, 2] += 0.01
        clouds = [Points.Points([FreeCAD.Vector(*row) for row in of]) for of in (rows, moved)]
        source = self.document.addObject("Points::Feature", "cloud")
        fingerprints = []
        for source.Points in clouds * 2:
            fingerprints.append(convert.fingerprint(source, convert.defaults()))
        self.assertEqual(fingerprints[:2], fingerprints[2:])
        self.assertNotEqual(*fingerprints[:2])

    def test_one_undo_takes_a_conversion_back(self):
        source = self.scan("relief.ply")
        self.document.UndoMode = 1
        self.converted(source, tolerance=0.5)
        self.assertEqual(len(self.document.Objects), 2)
        self.document.undo()
        self.assertEqual([obj.Name for obj in self.document.Objects], ["scan"])

    def test_a_document_keeps_shape_options_and_colours(self):
        source = self.scan("relief.ply")
        made, result = self.converted(source, tolerance=0.5, holes="filled")
        coloured, end = deviation.show(self.document, result)
        self.assertGreater(end, 0.0)
        names = result.Name, coloured.Name
        area, paint = result.Shape.Area, list(coloured.VertexColors)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "kept.FCStd")
            self.document.saveAs(path)
            FreeCAD.closeDocument(self.document.Name)
            self.document = FreeCAD.openDocument(path)
        result, coloured = map(self.document.getObject, names)
        self.assertAlmostEqual(result.Shape.Area, area)
        self.assertEqual((result.Tolerance.Value, result.Holes), (0.5, "filled"))
        self.assertEqual(len(coloured.VertexColors), len(paint))
        np.testing.assert_allclose(coloured.VertexColors, paint, atol=0.01)
        np.testing.assert_allclose(feature.deviations(result), made.deviations)
        self.assertEqual(result.Step.encode(), made.step())

    def test_a_placed_mesh_is_converted_where_it_is(self):
        source = self.scan("relief.ply")
        source.Placement.Base = FreeCAD.Vector(1000.0, 0.0, 0.0)
        _, result = self.converted(source, tolerance=0.5)
        self.assertAlmostEqual(result.Shape.BoundBox.Center.x, 1000.0, delta=5.0)

    def test_colours_show_the_sign(self):
        found = np.array([-1.0, 0.0, 1.0, np.nan])
        blue, middle, red, off = deviation.colours(found, 1.0)
        self.assertGreater(blue[2], blue[0])
        self.assertGreater(red[0], red[2])
        self.assertGreater(middle.min(), 0.8)
        self.assertEqual(tuple(off), deviation.GREY)

    def test_an_assembly_is_parts_and_links(self):
        for name in ("joint.glb", "joint.3mf"):
            made = scan2step.convert(fixture(name), up="z")
            # Labels are unique in a document.
            document = FreeCAD.newDocument("joint")
            self.addCleanup(FreeCAD.closeDocument, document.Name)
            whole = assembly.add(document, made, "joint")
            self.assertEqual(whole.TypeId, "App::Part")
            self.assertEqual(whole.Label, "pipe joint")
            self.assertEqual([child.TypeId for child in whole.Group], ["App::Link"] * 2 + ["App::Part"] * 4)
            screw = whole.Group[2]
            self.assertEqual([link.Label for link in screw.Group], ["bolt", "nut"])
            links = [*whole.Group[:2], *(link for group in whole.Group[2:] for link in group.Group)]
            shapes = {link.LinkedObject.Name for link in links}
            self.assertEqual((len(links), len(shapes)), (10, 3), "each part is there once")
            box = whole.Group[0].Shape.BoundBox
            self.assertAlmostEqual(box.ZMax, 0.0, 6)
            nut = screw.Group[1]
            self.assertTrue(nut.Shape.isValid())
            self.assertAlmostEqual(nut.Shape.CenterOfMass.z, -10.5, 4)
            places = sorted(round(link.Shape.CenterOfMass.x) for group in whole.Group[2:] for link in group.Group)
            self.assertEqual(places, [-22] * 4 + [22] * 4)

    def test_the_addon_has_the_version_of_the_package(self):
        with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "package.xml")) as file:
            self.assertIn(f"<version>{scan2step.__version__}</version>", file.read())
