#include "assets/cad_import/step_tree.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include <BRep_Tool.hxx>
#include <NCollection_DataMap.hxx>
#include <Quantity_ColorRGBA.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDF_Tool.hxx>
#include <TDataStd_Name.hxx>
#include <TDataStd_TreeNode.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <TopoDS.hxx>
#include <XCAFDoc.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_MaterialTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Trsf.hxx>

#include "assets/base/printable.h"
#include "assets/cad_import/step_tolerances.h"

namespace tandem::cad_import {
namespace {

constexpr std::size_t kLongestName = 200;
constexpr std::size_t kMostNodes = 200'000;
constexpr int kDeepest = 64;
constexpr std::array<float, 4> kPlain{0.6f, 0.62f, 0.65f, 1.0f};

/// Words that translators write where a name is missing.
bool meaningless(const std::string& name) {
  static const char* kWords[] = {"SOLID", "COMPOUND", "COMPSOLID", "SHELL", "FACE", "NONE", "UNNAMED"};
  std::string upper;
  for (const char c : name) upper += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  if (upper.rfind("=>[", 0) == 0 || upper.rfind("OPEN CASCADE STEP TRANSLATOR", 0) == 0) return true;
  if (upper.rfind("NAUO", 0) == 0) upper.erase(0, 4);
  if (std::none_of(upper.begin(), upper.end(), [](unsigned char c) { return std::isalpha(c) || c >= 128; }))
    return true;
  return std::find(std::begin(kWords), std::end(kWords), upper) != std::end(kWords);
}

std::string nameOf(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (label.IsNull() || !label.FindAttribute(TDataStd_Name::GetID(), name)) return {};
  std::string text(static_cast<std::size_t>(name->Get().LengthOfCString()), '\0');
  Standard_PCharacter buffer = text.data();
  name->Get().ToUTF8CString(buffer);
  text = printable(text, kLongestName);
  return meaningless(text) ? std::string() : text;
}

using Colour = std::optional<std::array<float, 4>>;

class TreeBuilder {
 public:
  TreeBuilder(const StepDocument& step, double metres)
      : shapes_(XCAFDoc_DocumentTool::ShapeTool(step.document->Main())),
        colours_(XCAFDoc_DocumentTool::ColorTool(step.document->Main())),
        tolerances_(step.document),
        metres_(metres) {}

  StepTree build(bool yUp) {
    TDF_LabelSequence roots;
    shapes_->GetFreeShapes(roots);
    for (int i = 1; i <= roots.Length(); ++i) anySolid_ = anySolid_ || hasSolid(roots.Value(i));
    CadNode top;
    if (!yUp) top.parentFromNode = glm::dmat4(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
    tree_.scene.nodes.push_back(top);
    for (int i = 1; i <= roots.Length(); ++i) visit(roots.Value(i), 0, {}, {}, 0);
    if (roots.Length() > 0) tree_.scene.name = tree_.scene.nodes[0].name = nameOf(roots.Value(1));
    addFinding("construction-shells", shells_,
               "Surfaces and shells beside the solids are taken for construction and left out.");
    addFinding("surfaces-only", loose_, "There are no solids in it: parts are surfaces, and may be open.");
    addFinding("no-shape", empty_, "Products have no shape in this file: in another file, or not exported.");
    addFinding("too-deep", cut_, "Products are nested too deeply or too many; those are left out.");
    return std::move(tree_);
  }

 private:
  void addFinding(const char* code, std::uint64_t count, const char* message) {
    if (count > 0) tree_.scene.findings.push_back({code, count, message});
  }

  static bool isSolid(const TopoDS_Shape& shape) {
    return shape.ShapeType() == TopAbs_SOLID ||
           (shape.ShapeType() == TopAbs_SHELL && BRep_Tool::IsClosed(shape));
  }

  static bool hasSolid(const TDF_Label& label) {
    for (const TopoDS_Shape& body : bodiesOf(XCAFDoc_ShapeTool::GetShape(label)))
      if (isSolid(body)) return true;
    return false;
  }

  /// Solids, then shells outside of solids, then faces outside of shells.
  static std::vector<TopoDS_Shape> bodiesOf(const TopoDS_Shape& shape) {
    std::vector<TopoDS_Shape> found;
    if (shape.IsNull()) return found;
    for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next()) found.push_back(at.Current());
    for (TopExp_Explorer at(shape, TopAbs_SHELL, TopAbs_SOLID); at.More(); at.Next())
      found.push_back(at.Current());
    for (TopExp_Explorer at(shape, TopAbs_FACE, TopAbs_SHELL); at.More(); at.Next())
      found.push_back(at.Current());
    return found;
  }

  glm::dmat4 matrixOf(const TopLoc_Location& location) const {
    const gp_Trsf& map = location.Transformation();
    glm::dmat4 matrix(1.0);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) matrix[column][row] = map.Value(row + 1, column + 1);
      matrix[3][row] = map.Value(row + 1, 4) * metres_;
    }
    return matrix;
  }

  template <typename T>
  Colour colourOf(const T& of) const {
    Quantity_ColorRGBA found;
    for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
      if (colours_->GetColor(of, type, found)) {
        const Quantity_Color& rgb = found.GetRGB();
        return std::array<float, 4>{static_cast<float>(rgb.Red()), static_cast<float>(rgb.Green()),
                                    static_cast<float>(rgb.Blue()), found.Alpha()};
      }
    return std::nullopt;
  }

  std::uint32_t indexOf(const std::array<float, 4>& colour) {
    const auto [it, isNew] =
        colourIndex_.emplace(colour, static_cast<std::uint32_t>(tree_.scene.colours.size()));
    if (isNew) tree_.scene.colours.push_back(colour);
    return it->second;
  }

  /// Adds a label and what is below it. `place` is the colour that an instance above sets for all below it.
  void visit(const TDF_Label& label, std::uint32_t parent, Colour place, const std::string& above,
             int depth) {
    if (depth > kDeepest || tree_.scene.nodes.size() > kMostNodes) {
      ++cut_;
      return;
    }
    TDF_Label product = label;
    CadNode node;
    if (XCAFDoc_ShapeTool::IsReference(label)) {
      XCAFDoc_ShapeTool::GetReferredShape(label, product);
      node.parentFromNode = matrixOf(XCAFDoc_ShapeTool::GetLocation(label));
      if (!place) place = colourOf(label);
    }
    node.name = nameOf(label);
    if (node.name.empty()) node.name = nameOf(product);
    if (node.name.empty()) node.name = above;
    node.parent = parent;
    node.tolerances = tolerances_.of(product);
    if (!XCAFDoc_ShapeTool::IsAssembly(product)) return addProduct(product, node, place);
    const auto index = static_cast<std::uint32_t>(tree_.scene.nodes.size());
    const std::string name = node.name;
    tree_.scene.nodes.push_back(std::move(node));
    TDF_LabelSequence components;
    XCAFDoc_ShapeTool::GetComponents(product, components);
    if (components.Length() == 0) ++empty_;
    for (int i = 1; i <= components.Length(); ++i) visit(components.Value(i), index, place, name, depth + 1);
  }

  void addProduct(const TDF_Label& product, CadNode node, const Colour& place) {
    std::vector<TopoDS_Shape> bodies = bodiesOf(XCAFDoc_ShapeTool::GetShape(product));
    if (bodies.empty()) {
      ++empty_;
      return;
    }
    const auto open = [](const TopoDS_Shape& body) { return !isSolid(body); };
    const auto surfaces = static_cast<std::uint64_t>(std::count_if(bodies.begin(), bodies.end(), open));
    (anySolid_ ? shells_ : loose_) += surfaces;
    if (anySolid_) bodies.erase(std::remove_if(bodies.begin(), bodies.end(), open), bodies.end());
    if (bodies.empty()) return;
    addMaterial(product, node);
    std::uint32_t parent = node.parent;
    if (bodies.size() > 1) {
      parent = static_cast<std::uint32_t>(tree_.scene.nodes.size());
      tree_.scene.nodes.push_back(node);
      node.parentFromNode = glm::dmat4(1.0);
      node.parent = parent;
    }
    const std::string name = node.name;
    for (const TopoDS_Shape& body : bodies) {
      TDF_Label own;
      shapes_->FindSubShape(product, body, own);
      if (bodies.size() > 1 && !nameOf(own).empty()) node.name = nameOf(own);
      const std::uint32_t mesh =
          bodyIndex(product, body, place, nameOf(product).empty() ? name : nameOf(product));
      node.mesh = mesh;
      tree_.bodies[mesh].instances.push_back(static_cast<std::uint32_t>(tree_.scene.nodes.size()));
      tree_.scene.nodes.push_back(node);
      node.name = name;
    }
  }

  void addMaterial(const TDF_Label& product, CadNode& node) const {
    Handle(TDataStd_TreeNode) link;
    if (!product.FindAttribute(XCAFDoc::MaterialRefGUID(), link) || !link->HasFather()) return;
    Handle(TCollection_HAsciiString) name, description, densityName, densityType;
    double density = 0.0;
    if (!XCAFDoc_DocumentTool::MaterialTool(product)->GetMaterial(link->Father()->Label(), name, description,
                                                                  density, densityName, densityType))
      return;
    if (!name.IsNull()) node.material = printable(name->ToCString(), kLongestName);
    constexpr double kFromGramPerCubicCentimetre = 1000.0;
    density *= kFromGramPerCubicCentimetre;
    if (density > 1.0 && density < 1e5) node.density = density;  // kg/m^3: from aerogel to osmium, and beyond
  }

  std::uint32_t bodyIndex(const TDF_Label& product, const TopoDS_Shape& shape, const Colour& place,
                          const std::string& name) {
    TCollection_AsciiString entry;
    TDF_Tool::Entry(product, entry);
    std::vector<std::uint32_t>& known = known_[entry.ToCString()];
    const std::uint32_t override = place ? indexOf(*place) : kNone;
    for (const std::uint32_t at : known)
      if (tree_.bodies[at].shape.IsSame(shape) && overrides_[at] == override) return at;
    Body body{shape, name, 0, {}, {}};
    colour(body, product, place);
    known.push_back(static_cast<std::uint32_t>(tree_.bodies.size()));
    overrides_.push_back(override);
    tree_.bodies.push_back(std::move(body));
    return known.back();
  }

  /// Colours of an instance stand above those of faces, solids and products, in this order.
  void colour(Body& body, const TDF_Label& product, const Colour& place) {
    TopTools_IndexedMapOfShape faces;
    TopExp::MapShapes(body.shape, TopAbs_FACE, faces);
    body.faceColours.assign(static_cast<std::size_t>(faces.Extent()), kNone);
    Colour whole = place;
    if (!place) {
      whole = colourOf(product);
      TDF_LabelSequence parts;
      XCAFDoc_ShapeTool::GetSubShapes(product, parts);
      for (int i = 1; i <= parts.Length(); ++i) {
        const Colour own = colourOf(parts.Value(i));
        if (!own) continue;
        const TopoDS_Shape part = XCAFDoc_ShapeTool::GetShape(parts.Value(i));
        if (part.IsSame(body.shape)) whole = own;
        if (const int face = faces.FindIndex(part); face > 0)
          body.faceColours[static_cast<std::size_t>(face) - 1] = indexOf(*own);
      }
    }
    body.colour = indexOf(whole.value_or(kPlain));
  }

  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colours_;
  StepTolerances tolerances_;
  double metres_;
  bool anySolid_ = false;
  std::uint64_t shells_ = 0, loose_ = 0, empty_ = 0, cut_ = 0;
  StepTree tree_;
  std::map<std::array<float, 4>, std::uint32_t> colourIndex_;
  std::map<std::string, std::vector<std::uint32_t>> known_;  // bodies of a product
  std::vector<std::uint32_t> overrides_;                     // B, the colour of their instance
};

}  // namespace

StepTree buildTree(const StepDocument& step, double metresPerMillimetre, bool yUp) {
  return TreeBuilder(step, metresPerMillimetre).build(yUp);
}

}  // namespace tandem::cad_import
