// make_step CASE OUT.step [UNIT]: STEP files with a known answer, for the tests of tandem-import.
//   fixture    a block with two bores, a pin of their diameter in each, turned by odd angles; a sketch
//   oversize   the same with pins 0.1 mm too thick
//   toleranced the fixture with a diameter and a cylindricity stated of the pin, and a flatness of the block
//   thousand   a thousand parts of a hundred shapes
//   bearing    a shaft in a plain bearing, whose cap has four bolts, one of them too long for its hole: the
//              scene assets/scenes/bearing.step of `client/demo review`

#include <cmath>
#include <cstdio>
#include <string>

#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <XCAFDimTolObjects_DimensionObject.hxx>
#include <XCAFDimTolObjects_GeomToleranceObject.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DimTolTool.hxx>
#include <XCAFDoc_Dimension.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_GeomTolerance.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Ax2.hxx>
#include <gp_Pln.hxx>

namespace {

constexpr double kHoleRadius = 5.0;  // mm

class StepFile {
 public:
  explicit StepFile(const char* called) : document_(new TDocStd_Document("BinXCAF")) {
    XCAFDoc_DocumentTool::Set(document_->Main(), false);
    shapes_ = XCAFDoc_DocumentTool::ShapeTool(document_->Main());
    top_ = shapes_->NewShape();
    name(top_, called);
  }

  TDF_Label add(const TopoDS_Shape& shape, const char* called) {
    const TDF_Label label = shapes_->AddShape(shape, false);
    name(label, called);
    return label;
  }

  void place(const TDF_Label& product, const char* called, const gp_Vec& at, double degrees) {
    gp_Trsf turn, shift;
    turn.SetRotation(gp_Ax1({0, 0, 0}, {0, 0, 1}), degrees * M_PI / 180.0);
    shift.SetTranslation(at);
    name(shapes_->AddComponent(top_, product, TopLoc_Location(shift * turn)), called);
  }

  void colour(const TDF_Label& label, const Quantity_Color& as) {
    XCAFDoc_DocumentTool::ColorTool(document_->Main())->SetColor(label, as, XCAFDoc_ColorSurf);
  }

  void steel(const TDF_Label& label) {
    const auto text = [](const char* of) {
      return Handle(TCollection_HAsciiString)(new TCollection_HAsciiString(of));
    };
    XCAFDoc_DocumentTool::MaterialTool(document_->Main())
        ->SetMaterial(label, text("Steel"), text(""), 7.85, text("density measure"),
                      text("POSITIVE_RATIO_MEASURE"));
  }

  void diameter(const TDF_Label& product, const TopoDS_Shape& face, double value, double upper,
                double lower) {
    const TDF_Label label = tolerances()->AddDimension();
    Handle(XCAFDoc_Dimension) dimension;
    label.FindAttribute(XCAFDoc_Dimension::GetID(), dimension);
    Handle(XCAFDimTolObjects_DimensionObject) object = new XCAFDimTolObjects_DimensionObject();
    object->SetType(XCAFDimTolObjects_DimensionType_Size_Diameter);
    object->SetValue(value);
    object->SetUpperTolValue(upper);
    object->SetLowerTolValue(lower);
    dimension->SetObject(object);
    tolerances()->SetDimension(shapes_->AddSubShape(product, face), label);
  }
  void tolerance(const TDF_Label& product, const TopoDS_Shape& face, XCAFDimTolObjects_GeomToleranceType type,
                 double value) {
    const TDF_Label label = tolerances()->AddGeomTolerance();
    Handle(XCAFDoc_GeomTolerance) tolerance;
    label.FindAttribute(XCAFDoc_GeomTolerance::GetID(), tolerance);
    Handle(XCAFDimTolObjects_GeomToleranceObject) object = new XCAFDimTolObjects_GeomToleranceObject();
    object->SetType(type);
    object->SetValue(value);
    tolerance->SetObject(object);
    tolerances()->SetGeomTolerance(shapes_->AddSubShape(product, face), label);
  }

  bool write(const char* path, const char* unit) {
    shapes_->UpdateAssemblies();
    STEPCAFControl_Controller::Init();
    Interface_Static::SetCVal("write.step.unit", unit);
    // Tolerances are of AP242 alone.
    if (toleranced_) Interface_Static::SetCVal("write.step.schema", "AP242DIS");
    STEPCAFControl_Writer writer;
    writer.SetColorMode(true);
    writer.SetNameMode(true);
    writer.SetDimTolMode(true);
    return writer.Transfer(document_, STEPControl_AsIs) && writer.Write(path) == IFSelect_RetDone;
  }

 private:
  Handle(XCAFDoc_DimTolTool) tolerances() {
    toleranced_ = true;
    return XCAFDoc_DocumentTool::DimTolTool(document_->Main());
  }
  static void name(const TDF_Label& label, const char* called) { TDataStd_Name::Set(label, called); }

  Handle(TDocStd_Document) document_;
  Handle(XCAFDoc_ShapeTool) shapes_;
  TDF_Label top_;
  bool toleranced_ = false;
};

TopoDS_Shape cylinder(double x, double y, double z, double radius, double length) {
  return BRepPrimAPI_MakeCylinder(gp_Ax2({x, y, z}, {0, 0, 1}), radius, length).Shape();
}

TopoDS_Shape block(double thickness) {
  TopoDS_Shape solid = BRepPrimAPI_MakeBox(60.0, 40.0, thickness).Shape();
  for (const double x : {15.0, 45.0})
    solid = BRepAlgoAPI_Cut(solid, cylinder(x, 20.0, -1.0, kHoleRadius, thickness + 2.0)).Shape();
  return TopExp_Explorer(solid, TopAbs_SOLID).Current();
}

/// The first face of a shape that lies on a surface of this kind.
TopoDS_Face faceOf(const TopoDS_Shape& shape, GeomAbs_SurfaceType kind) {
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
    const TopoDS_Face face = TopoDS::Face(faces.Current());
    if (BRepAdaptor_Surface(face).GetType() == kind) return face;
  }
  return {};
}

void addFixture(StepFile& file, double pinRadius, bool toleranced = false) {
  const TopoDS_Shape ofBody = block(20.0), ofPin = cylinder(0.0, 0.0, 0.0, pinRadius, 40.0);
  const TDF_Label body = file.add(ofBody, "body");
  const TDF_Label pin = file.add(ofPin, "pin");
  const TDF_Label sketch =
      file.add(BRepBuilderAPI_MakeFace(gp_Pln(), -50.0, 50.0, -50.0, 50.0).Shape(), "sketch");
  file.colour(pin, Quantity_Color(1.0, 0.0, 0.0, Quantity_TOC_RGB));
  file.steel(pin);
  file.place(body, "housing", {0, 0, 0}, 0.0);
  file.place(pin, "left pin", {15, 20, -10}, 17.0);
  file.place(pin, "", {45, 20, -10}, -33.0);
  file.place(sketch, "sketch", {0, 0, 0}, 0.0);
  if (!toleranced) return;
  const TopoDS_Face round = faceOf(ofPin, GeomAbs_Cylinder);
  file.diameter(pin, round, 2.0 * pinRadius, 0.018, 0.002);
  file.tolerance(pin, round, XCAFDimTolObjects_GeomToleranceType_Cylindricity, 0.01);
  file.tolerance(body, faceOf(ofBody, GeomAbs_Plane), XCAFDimTolObjects_GeomToleranceType_Flatness, 0.05);
}

void addThousand(StepFile& file) {
  for (int shape = 0; shape < 100; ++shape) {
    const TDF_Label product = file.add(block(5.0 + 0.1 * shape), ("plate " + std::to_string(shape)).c_str());
    for (int k = 0; k < 10; ++k) file.place(product, "", {70.0 * k, 50.0 * shape, 0.0}, 0.0);
  }
}

TopoDS_Shape lying(double from, double radius, double length) {
  return BRepPrimAPI_MakeCylinder(gp_Ax2({0.0, from, 0.0}, {0, 1, 0}), radius, length).Shape();
}

TopoDS_Shape both(const TopoDS_Shape& a, const TopoDS_Shape& b) { return BRepAlgoAPI_Fuse(a, b).Shape(); }

/// A slab from `low` to `high` over the axis of the shaft, with half of the seat of the bush and four holes.
TopoDS_Shape bearingHalf(double low, double high, double holeRadius, double holeBottom) {
  TopoDS_Shape solid = BRepPrimAPI_MakeBox(gp_Pnt(-60.0, -30.0, low), gp_Pnt(60.0, 30.0, high)).Shape();
  solid = BRepAlgoAPI_Cut(solid, lying(-31.0, 20.0, 62.0)).Shape();
  for (const double x : {-42.0, 42.0})
    for (const double y : {-18.0, 18.0})
      solid = BRepAlgoAPI_Cut(solid, cylinder(x, y, holeBottom, holeRadius, high - holeBottom + 1.0)).Shape();
  return TopExp_Explorer(solid, TopAbs_SOLID).Current();
}

/// An M8 bolt whose head rests on z = 0.
TopoDS_Shape bolt(double length) {
  return both(cylinder(0.0, 0.0, 0.0, 6.5, 8.0), cylinder(0.0, 0.0, -length, 4.0, length));
}

void addBearing(StepFile& file) {
  const auto colour = [&](const TDF_Label& label, double red, double green, double blue) {
    file.colour(label, Quantity_Color(red, green, blue, Quantity_TOC_sRGB));
  };
  const TDF_Label base = file.add(bearingHalf(-40.0, 0.0, 4.1, -30.0), "base");
  const TDF_Label cap = file.add(bearingHalf(0.0, 34.0, 4.5, -1.0), "cap");
  const TDF_Label bush =
      file.add(BRepAlgoAPI_Cut(lying(-30.0, 20.0, 60.0), lying(-31.0, 15.0, 62.0)).Shape(), "bush");
  const TDF_Label shaft = file.add(both(lying(-60.0, 14.95, 140.0), lying(31.0, 22.0, 8.0)), "shaft");
  const TDF_Label shortBolt = file.add(bolt(62.0), "bolt M8 x 62"),
                  longBolt = file.add(bolt(68.0), "bolt M8 x 68");
  colour(base, 0.42, 0.47, 0.53);
  colour(cap, 0.30, 0.45, 0.62);
  colour(bush, 0.80, 0.58, 0.25);
  colour(shaft, 0.72, 0.73, 0.75);
  for (const TDF_Label& steel : {shaft, shortBolt, longBolt}) file.steel(steel);
  file.place(base, "base", {0, 0, 0}, 0.0);
  file.place(cap, "cap", {0, 0, 0}, 0.0);
  file.place(bush, "bush", {0, 0, 0}, 0.0);
  file.place(shaft, "shaft", {0, 0, 0}, 0.0);
  file.place(shortBolt, "bolt 1", {-42, -18, 34}, 0.0);
  file.place(shortBolt, "bolt 2", {-42, 18, 34}, 0.0);
  file.place(shortBolt, "bolt 3", {42, -18, 34}, 0.0);
  file.place(longBolt, "bolt 4", {42, 18, 34}, 0.0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  Message::DefaultMessenger()->ChangePrinters().Clear();
  const std::string which = argv[1];
  StepFile file(which.c_str());
  if (which == "fixture") addFixture(file, kHoleRadius);
  if (which == "oversize") addFixture(file, kHoleRadius + 0.1);
  if (which == "toleranced") addFixture(file, kHoleRadius, true);
  if (which == "thousand") addThousand(file);
  if (which == "bearing") addBearing(file);
  return file.write(argv[2], argc > 3 ? argv[3] : "MM") ? 0 : 1;
}
