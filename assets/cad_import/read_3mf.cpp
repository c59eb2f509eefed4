#include "assets/cad_import/read_3mf.h"

#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Model/COM/NMR_DLLInterfaces.h>

#include "assets/base/printable.h"

namespace tandem::cad_import {
namespace {

constexpr std::size_t kLongestName = 200, kLongestReason = 300;  // bytes
constexpr std::array<float, 4> kGrey{0.6f, 0.62f, 0.65f, 1.0f};

/// One of lib3mf's objects, released with its owner.
class Handle {
 public:
  Handle() = default;
  Handle(Handle&& other) noexcept : held_(std::exchange(other.held_, nullptr)) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (held_ != nullptr) NMR::lib3mf_release(held_);
  }

  NMR::PLib3MFBase* get() const { return held_; }
  NMR::PLib3MFBase** out() { return &held_; }

 private:
  NMR::PLib3MFBase* held_ = nullptr;
};

std::string reasonOf(NMR::PLib3MFBase* of, int code) {
  DWORD ignored = 0;
  LPCSTR text = nullptr;
  if (of != nullptr && NMR::lib3mf_getlasterror(of, &ignored, &text) == LIB3MF_OK && text != nullptr)
    return printable(text, kLongestReason);
  return "lib3mf says " + std::to_string(code);
}

void require(int code, const Handle& of) {
  if (code != LIB3MF_OK)
    throw std::runtime_error("not a 3MF file that can be read: " + reasonOf(of.get(), code));
}

template <typename Getter>
std::string textOf(const Handle& of, Getter getter) {
  ULONG size = 0;
  if (getter(of.get(), nullptr, 0, &size) != LIB3MF_OK) return {};
  std::string text(std::size_t{size} + 1, '\0');
  if (getter(of.get(), text.data(), size + 1, &size) != LIB3MF_OK) return {};
  text.resize(text.find('\0'));
  return printable(text, kLongestName);
}

float linear(BYTE srgb) {
  const double c = srgb / 255.0;
  return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

std::array<float, 4> linear(const NMR::MODELMESHCOLOR_SRGB& c) {
  return {linear(c.m_Red), linear(c.m_Green), linear(c.m_Blue), static_cast<float>(c.m_Alpha / 255.0)};
}

glm::dmat4 matrixOf(const NMR::MODELTRANSFORM& transform) {
  glm::dmat4 matrix(1.0);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) matrix[column][row] = transform.m_fFields[row][column];
  return matrix;
}

/// How a triangle looks.
struct Look {
  std::array<float, 4> colour = kGrey;
  std::string material;
};

class PackageReader {
 public:
  ThreeMfPackage read(const std::string& path, const std::function<void(double)>& progress) {
    require(NMR::lib3mf_createmodel(model_.out()), model_);
    Handle reader;
    require(NMR::lib3mf_model_queryreader(model_.get(), "3mf", reader.out()), model_);
    progress_ = &progress;
    NMR::lib3mf_reader_setprogresscallback(reader.get(), &PackageReader::onProgress, this);
    require(NMR::lib3mf_reader_readfromfileutf8(reader.get(), path.c_str()), reader);
    addWarnings(reader);
    DWORD unit = 0;
    require(NMR::lib3mf_model_getunit(model_.get(), &unit), model_);
    static constexpr const char* kUnits[] = {"micrometer", "mm", "cm", "inch", "foot", "m"};
    if (unit >= std::size(kUnits)) throw std::runtime_error("its unit is not known");
    package_.unit = kUnits[unit];
    addObjects();
    addBuilt();
    return std::move(package_);
  }

 private:
  static bool onProgress(int share, NMR::ProgressIdentifier, void* self) {
    if (share >= 0) (*static_cast<PackageReader*>(self)->progress_)(share / 100.0);
    return true;
  }

  void addWarnings(const Handle& reader) {
    DWORD count = 0, code = 0;
    if (NMR::lib3mf_reader_getwarningcount(reader.get(), &count) != LIB3MF_OK || count == 0) return;
    package_.warnings = count;
    package_.firstWarning = textOf(reader, [&](auto of, LPSTR text, ULONG size, ULONG* needed) {
      return NMR::lib3mf_reader_getwarningutf8(of, 0, &code, text, size, needed);
    });
  }

  void addObjects() {
    std::vector<Handle> objects;
    Handle all;
    require(NMR::lib3mf_model_getobjects(model_.get(), all.out()), model_);
    for (BOOL more = 0;;) {
      require(NMR::lib3mf_resourceiterator_movenext(all.get(), &more), all);
      if (more == 0) break;
      Handle object;
      DWORD id = 0;
      require(NMR::lib3mf_resourceiterator_getcurrent(all.get(), object.out()), all);
      require(NMR::lib3mf_resource_getresourceid(object.get(), &id), object);
      indices_[id] = static_cast<std::uint32_t>(objects.size());
      objects.push_back(std::move(object));
    }
    for (const Handle& object : objects) package_.objects.push_back(objectOf(object));
  }

  std::uint32_t indexOf(DWORD id) const {
    const auto found = indices_.find(id);
    if (found == indices_.end()) throw std::runtime_error("it refers to an object that is not there");
    return found->second;
  }

  ThreeMfObject objectOf(const Handle& handle) {
    ThreeMfObject object;
    object.name = textOf(handle, NMR::lib3mf_object_getnameutf8);
    if (object.name.empty()) object.name = textOf(handle, NMR::lib3mf_object_getpartnumberutf8);
    DWORD type = NMR::MODELOBJECTTYPE_MODEL;
    require(NMR::lib3mf_object_gettype(handle.get(), &type), handle);
    object.support = type == NMR::MODELOBJECTTYPE_SUPPORT || type == NMR::MODELOBJECTTYPE_SOLIDSUPPORT;
    BOOL isMesh = 0;
    require(NMR::lib3mf_object_ismeshobject(handle.get(), &isMesh), handle);
    if (isMesh != 0)
      addMesh(handle, object);
    else
      addChildren(handle, object);
    return object;
  }

  void addChildren(const Handle& handle, ThreeMfObject& object) {
    DWORD count = 0;
    require(NMR::lib3mf_componentsobject_getcomponentcount(handle.get(), &count), handle);
    for (DWORD i = 0; i < count; ++i) {
      Handle component;
      DWORD id = 0;
      NMR::MODELTRANSFORM transform{};
      require(NMR::lib3mf_componentsobject_getcomponent(handle.get(), i, component.out()), handle);
      require(NMR::lib3mf_component_getobjectresourceid(component.get(), &id), component);
      require(NMR::lib3mf_component_gettransform(component.get(), &transform), component);
      object.children.push_back({indexOf(id), matrixOf(transform), {}});
    }
  }

  void addBuilt() {
    Handle all;
    require(NMR::lib3mf_model_getbuilditems(model_.get(), all.out()), model_);
    for (BOOL more = 0;;) {
      require(NMR::lib3mf_builditemiterator_movenext(all.get(), &more), all);
      if (more == 0) break;
      Handle item;
      DWORD id = 0;
      NMR::MODELTRANSFORM transform{};
      require(NMR::lib3mf_builditemiterator_getcurrent(all.get(), item.out()), all);
      require(NMR::lib3mf_builditem_getobjectresourceid(item.get(), &id), item);
      require(NMR::lib3mf_builditem_getobjecttransform(item.get(), &transform), item);
      package_.built.push_back(
          {indexOf(id), matrixOf(transform), textOf(item, NMR::lib3mf_builditem_getpartnumberutf8)});
    }
  }

  void addMesh(const Handle& handle, ThreeMfObject& object) {
    DWORD points = 0, faces = 0;
    require(NMR::lib3mf_meshobject_getvertexcount(handle.get(), &points), handle);
    require(NMR::lib3mf_meshobject_gettrianglecount(handle.get(), &faces), handle);
    std::vector<NMR::MODELMESHVERTEX> vertices(points);
    std::vector<NMR::MODELMESHTRIANGLE> triangles(faces);
    if (points > 0)
      require(NMR::lib3mf_meshobject_getvertices(handle.get(), vertices.data(), points, &points), handle);
    if (faces > 0)
      require(NMR::lib3mf_meshobject_gettriangleindices(handle.get(), triangles.data(), faces, &faces),
              handle);
    for (const NMR::MODELMESHVERTEX& v : vertices)
      object.mesh.positions.emplace_back(v.m_fPosition[0], v.m_fPosition[1], v.m_fPosition[2]);
    Handle properties;
    require(NMR::lib3mf_meshobject_createpropertyhandler(handle.get(), properties.out()), handle);
    const Look usual = defaultLook(handle);
    std::optional<std::string> material;
    for (DWORD i = 0; i < faces; ++i) {
      const DWORD* corners = triangles[i].m_nIndices;
      if (!isSound(object.mesh, corners)) {
        ++package_.unusable;
        continue;
      }
      const Look look = lookOf(properties, i, usual);
      std::vector<std::uint32_t>& of = groupOf(object.mesh, look.colour).corners;
      of.insert(of.end(), corners, corners + 3);
      if (material.value_or(look.material) != look.material)
        material = std::string();
      else if (!material)
        material = look.material;
    }
    object.material = material.value_or(std::string());
  }

  /// Three different corners that are numbers.
  static bool isSound(const CadMesh& mesh, const DWORD* corners) {
    for (int i = 0; i < 3; ++i) {
      if (corners[i] >= mesh.positions.size()) return false;
      const glm::dvec3& at = mesh.positions[corners[i]];
      if (!std::isfinite(at.x + at.y + at.z)) return false;
    }
    const auto at = [&](int i) { return mesh.positions[corners[i]]; };
    return at(0) != at(1) && at(1) != at(2) && at(2) != at(0);
  }

  CadTriangles& groupOf(CadMesh& mesh, const std::array<float, 4>& colour) {
    const auto [known, isNew] =
        colours_.try_emplace(colour, static_cast<std::uint32_t>(package_.colours.size()));
    if (isNew) package_.colours.push_back(colour);
    if (!mesh.triangles.empty() && mesh.triangles.back().colour == known->second)
      return mesh.triangles.back();
    for (CadTriangles& group : mesh.triangles)
      if (group.colour == known->second) return group;
    return mesh.triangles.emplace_back(CadTriangles{known->second, {}});
  }

  Look materialLook(DWORD group, DWORD index) {
    const auto [known, isNew] = materials_.try_emplace({group, index});
    if (!isNew) return known->second;
    Handle materials;
    if (NMR::lib3mf_model_getbasematerialbyid(model_.get(), group, materials.out()) != LIB3MF_OK)
      return known->second;
    NMR::MODELMESHCOLOR_SRGB c{};
    if (NMR::lib3mf_basematerial_getdisplaycolor(materials.get(), index, &c.m_Red, &c.m_Green, &c.m_Blue,
                                                 &c.m_Alpha) == LIB3MF_OK)
      known->second.colour = linear(c);
    known->second.material = textOf(materials, [&](auto of, LPSTR text, ULONG size, ULONG* needed) {
      return NMR::lib3mf_basematerial_getnameutf8(of, index, text, size, needed);
    });
    return known->second;
  }

  Look defaultLook(const Handle& object) {
    Handle properties;
    NMR::eModelPropertyType type = NMR::MODELPROPERTYTYPE_NONE;
    if (NMR::lib3mf_object_createdefaultpropertyhandler(object.get(), properties.out()) != LIB3MF_OK ||
        NMR::lib3mf_defaultpropertyhandler_getpropertytype(properties.get(), &type) != LIB3MF_OK)
      return {};
    DWORD group = 0, index = 0;
    NMR::MODELMESHCOLOR_SRGB colour{};
    if (type == NMR::MODELPROPERTYTYPE_BASEMATERIALS &&
        NMR::lib3mf_defaultpropertyhandler_getbasematerial(properties.get(), &group, &index) == LIB3MF_OK)
      return materialLook(group, index);
    if (type == NMR::MODELPROPERTYTYPE_COLOR &&
        NMR::lib3mf_defaultpropertyhandler_getcolor(properties.get(), 0, &colour) == LIB3MF_OK)
      return {linear(colour), {}};
    return {};
  }

  /// Of a triangle whose corners differ the first one's counts.
  Look lookOf(const Handle& properties, DWORD triangle, const Look& usual) {
    NMR::eModelPropertyType type = NMR::MODELPROPERTYTYPE_NONE;
    if (NMR::lib3mf_propertyhandler_getpropertytype(properties.get(), triangle, &type) != LIB3MF_OK)
      return usual;
    DWORD group = 0, index = 0;
    NMR::MODELMESH_TRIANGLECOLOR_SRGB colours{};
    if (type == NMR::MODELPROPERTYTYPE_BASEMATERIALS &&
        NMR::lib3mf_propertyhandler_getbasematerial(properties.get(), triangle, &group, &index) == LIB3MF_OK)
      return materialLook(group, index);
    if (type == NMR::MODELPROPERTYTYPE_COLOR &&
        NMR::lib3mf_propertyhandler_getcolor(properties.get(), triangle, &colours) == LIB3MF_OK)
      return {linear(colours.m_Colors[0]), {}};
    return usual;
  }

  Handle model_;
  ThreeMfPackage package_;
  const std::function<void(double)>* progress_ = nullptr;
  std::map<DWORD, std::uint32_t> indices_;  // of objects, by lib3mf's id
  std::map<std::array<float, 4>, std::uint32_t> colours_;
  std::map<std::pair<DWORD, DWORD>, Look> materials_;
};

}  // namespace

Result<ThreeMfPackage> read3mf(const std::string& path, const std::function<void(double)>& progress) try {
  return PackageReader().read(path, progress);
} catch (const std::runtime_error& error) {
  return Error{error.what()};
}

}  // namespace tandem::cad_import
