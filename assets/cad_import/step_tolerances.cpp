#include "assets/cad_import/step_tolerances.h"

#include <cstdio>

#include <TDF_LabelSequence.hxx>
#include <TDF_Tool.hxx>
#include <XCAFDimTolObjects_DimensionObject.hxx>
#include <XCAFDimTolObjects_GeomToleranceObject.hxx>
#include <XCAFDoc_DimTolTool.hxx>
#include <XCAFDoc_Dimension.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_GeomTolerance.hxx>
#include <XCAFDoc_ShapeTool.hxx>

namespace tandem::cad_import {
namespace {

std::string entryOf(const TDF_Label& label) {
  TCollection_AsciiString entry;
  TDF_Tool::Entry(label, entry);
  return entry.ToCString();
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string wordOf(XCAFDimTolObjects_DimensionType type) {
  switch (type) {
    case XCAFDimTolObjects_DimensionType_Size_Diameter:
    case XCAFDimTolObjects_DimensionType_Size_SphericalDiameter:
      return "diameter";
    case XCAFDimTolObjects_DimensionType_Size_Radius:
    case XCAFDimTolObjects_DimensionType_Size_SphericalRadius:
      return "radius";
    case XCAFDimTolObjects_DimensionType_Size_Angular:
    case XCAFDimTolObjects_DimensionType_Location_Angular:
      return "angle";
    case XCAFDimTolObjects_DimensionType_Size_Thickness:
      return "thickness";
    default:
      return "length";
  }
}

std::string wordOf(XCAFDimTolObjects_GeomToleranceType type) {
  static const char* kWords[] = {"tolerance",       "angularity",       "circular runout", "circularity",
                                 "coaxiality",      "concentricity",    "cylindricity",    "flatness",
                                 "parallelism",     "perpendicularity", "position",        "line profile",
                                 "surface profile", "straightness",     "symmetry",        "total runout"};
  const auto at = static_cast<std::size_t>(type);
  return at < std::size(kWords) ? kWords[at] : kWords[0];
}

std::string inWords(const XCAFDimTolObjects_DimensionObject& dimension) {
  const std::string word = wordOf(dimension.GetType());
  std::string text = word + " " + number(dimension.GetValue()) + (word == "angle" ? " degrees" : " mm");
  if (dimension.IsDimWithPlusMinusTolerance())
    text += " +" + number(dimension.GetUpperTolValue()) + " -" + number(dimension.GetLowerTolValue());
  else if (dimension.IsDimWithRange())
    text += ", " + number(dimension.GetLowerBound()) + " to " + number(dimension.GetUpperBound());
  return text;
}

/// Entries of the products that the label's shapes belong to.
std::vector<std::string> productsOf(const XCAFDoc_DimTolTool& tool, const TDF_Label& label) {
  TDF_LabelSequence first, second;
  std::vector<std::string> found;
  tool.GetRefShapeLabel(label, first, second);
  for (const TDF_LabelSequence* list : {&first, &second})
    for (int i = 1; i <= list->Length(); ++i) {
      TDF_Label of = list->Value(i);
      if (XCAFDoc_ShapeTool::IsSubShape(of)) of = of.Father();
      const std::string entry = entryOf(of);
      if (found.empty() || found.back() != entry) found.push_back(entry);
    }
  return found;
}

}  // namespace

StepTolerances::StepTolerances(const Handle(TDocStd_Document) & document) {
  const Handle(XCAFDoc_DimTolTool) tool = XCAFDoc_DocumentTool::DimTolTool(document->Main());
  TDF_LabelSequence labels;
  tool->GetDimensionLabels(labels);
  for (int i = 1; i <= labels.Length(); ++i) {
    Handle(XCAFDoc_Dimension) dimension;
    if (!labels.Value(i).FindAttribute(XCAFDoc_Dimension::GetID(), dimension)) continue;
    const Handle(XCAFDimTolObjects_DimensionObject) object = dimension->GetObject();
    if (object.IsNull() || object->GetValues().IsNull()) continue;
    for (const std::string& product : productsOf(*tool, labels.Value(i)))
      byProduct_[product].push_back(inWords(*object));
  }
  labels.Clear();
  tool->GetGeomToleranceLabels(labels);
  for (int i = 1; i <= labels.Length(); ++i) {
    Handle(XCAFDoc_GeomTolerance) tolerance;
    if (!labels.Value(i).FindAttribute(XCAFDoc_GeomTolerance::GetID(), tolerance)) continue;
    const Handle(XCAFDimTolObjects_GeomToleranceObject) object = tolerance->GetObject();
    if (object.IsNull()) continue;
    for (const std::string& product : productsOf(*tool, labels.Value(i)))
      byProduct_[product].push_back(wordOf(object->GetType()) + " " + number(object->GetValue()) + " mm");
  }
}

std::vector<std::string> StepTolerances::of(const TDF_Label& product) const {
  const auto found = byProduct_.find(entryOf(product));
  return found == byProduct_.end() ? std::vector<std::string>() : found->second;
}

}  // namespace tandem::cad_import
