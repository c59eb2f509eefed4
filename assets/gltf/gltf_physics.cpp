#include "assets/gltf/gltf_physics.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "assets/gltf/gltf_json.h"
#include "assets/gltf/gltf_surface.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

// The values of false and true.
constexpr const char* kAxisNames[] = {"linear", "angular"};
constexpr double kLeastDensity = 1.0, kMostDensity = 1e5;  // kg/m^3: beyond aerogel and osmium
constexpr const char* kModeNames[] = {"force", "acceleration"};

/// The entries of one dialect within an array that holds KHR's entries first and OMI's after them.
struct Section {
  std::size_t first = 0, count = 0;
};

class PhysicsReader {
 public:
  explicit PhysicsReader(const GltfDocument& document) : document_(document), json_(document.json) {}

  GltfPhysics read() {
    readShapes("KHR_implicit_shapes", khrShapes_, 0.25);
    readShapes("OMI_physics_shape", omiShapes_, 0.5);
    readBodiesSection("KHR_physics_rigid_bodies", khrMaterials_, khrFilters_);
    readBodiesSection("OMI_physics_body", omiMaterials_, omiFilters_);
    readJoints("KHR_physics_rigid_bodies", khrJoints_);
    readJoints("OMI_physics_joint", omiJoints_);
    readGravity();
    const Json& nodes = json_.member("nodes");
    out_.nodes.resize(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) readNode(nodes.at(i), i);
    addCounted("trigger", triggers_, "Triggers are not simulated.");
    addCounted("convex-hull", hulls_, "Colliders that ask for a convex hull are felt as their exact mesh.");
    addCounted("old-collider-form", oldForms_,
               "Colliders state their shape outside of 'geometry', an outdated form.");
    addCounted("unused-haptic-property", unusedHaptics_.count,
               "extras.haptic holds properties that are not known: " + unusedHaptics_.names + '.');
    return std::move(out_);
  }

 private:
  void addCounted(const char* code, std::uint64_t count, const std::string& message) {
    if (count > 0) out_.findings.push_back({Finding::Severity::note, code, "", count, message});
  }

  // --- shapes

  void readRadii(const JsonObject& shape, double fallback, ImplicitShape& out) {
    out.height = shape.sizeOr("height", 0.5);
    out.radiusTop = shape.sizeOr("radiusTop", fallback);
    out.radiusBottom = shape.sizeOr("radiusBottom", fallback);
    if (out.radiusTop == 0.0 && out.radiusBottom == 0.0) shape.fail("radiusTop", "both radii are zero");
  }

  PhysicsShape readShape(const JsonObject& entry, double radiusFallback) {
    const std::string type = entry.text("type", "");
    const JsonObject shape =
        type.empty() ? entry : entry.object(type.c_str()).value_or(JsonObject::empty(entry.place()));
    PhysicsShape out;
    ImplicitShape& s = out.shape;
    if (type == "box") {
      s.kind = ImplicitShape::Kind::box;
      s.size = shape.vector("size").value_or(glm::dvec3(1.0));
      if (!(s.size.x > 0.0 && s.size.y > 0.0 && s.size.z > 0.0)) shape.fail("size", "must be positive");
    } else if (type == "sphere") {
      s.kind = ImplicitShape::Kind::sphere;
      s.radiusTop = s.radiusBottom = shape.sizeOr("radius", 0.5);
      if (s.radiusBottom == 0.0) shape.fail("radius", "must be positive");
    } else if (type == "capsule") {
      s.kind = ImplicitShape::Kind::capsule;
      readRadii(shape, radiusFallback, s);
    } else if (type == "cylinder") {
      s.kind = ImplicitShape::Kind::cylinder;
      readRadii(shape, radiusFallback, s);
      if (s.height == 0.0) shape.fail("height", "must be positive");
    } else if (type == "plane") {
      s.kind = ImplicitShape::Kind::plane;
      s.size = {shape.sizeOr("sizeX", 0.0), 0.0, shape.sizeOr("sizeZ", 0.0)};
    } else if (type == "convex" || type == "trimesh") {
      out.mesh = shape.requiredIndex("mesh", document_.model.meshes.size(), "meshes");
      if (type == "convex") ++hulls_;
    } else {
      entry.fail("type", "'" + type.substr(0, 40) + "' is not a known shape");
    }
    return out;
  }

  void readShapes(const char* extension, Section& section, double radiusFallback) {
    section.first = out_.shapes.size();
    if (const auto object = extensionOf(json_, extension, "extensions"))
      for (const JsonObject& shape : object->objects("shapes"))
        out_.shapes.push_back(readShape(shape, radiusFallback));
    section.count = out_.shapes.size() - section.first;
  }

  // --- materials and filters

  /// Checks the numbers of a contact by the ranges of the material that they become.
  static void checkContact(const PhysicsSurface& surface, const std::string& place) {
    Material material;
    material.stiffness = surface.stiffness;
    material.damping = surface.damping;
    material.staticFriction = surface.staticFriction;
    material.dynamicFriction = surface.dynamicFriction;
    material.restitution = surface.restitution;
    refuseFault(outOfRange(material), place);
  }

  /// Reads the surface of `holder`.extras.haptic; false if there is no such object or it describes no
  /// surface. Only a node (`ofNode`) has a tolerance.
  bool readHaptic(const Json& holder, const std::string& place, PhysicsSurface& surface, bool ofNode) {
    const Json& value = holder.member("extras").member("haptic");
    if (value.isAbsent()) return false;
    const JsonObject haptic(value, place + ".extras.haptic");
    // A force field (gltf_fields.h) and a tolerance do not describe the node's surface.
    const std::size_t others = (haptic.has("field") ? 1u : 0u) + (haptic.has("tolerance") ? 1u : 0u);
    if (others > 0 && haptic.raw().size() == others) return false;
    surface.stiffness = haptic.sizeOr("stiffness", surface.stiffness);
    surface.damping = haptic.sizeOr("damping", surface.damping);
    surface.staticFriction = haptic.sizeOr("staticFriction", surface.staticFriction);
    surface.dynamicFriction = haptic.sizeOr("dynamicFriction", surface.dynamicFriction);
    // gltf_fields.cpp and gltf_controls.cpp read "field" and "control".
    checkContact(surface, haptic.place());
    readSurface(haptic, json_, surface.feel, unusedHaptics_);
    surface.saysHowSmooth = haptic.has("creaseAngle");
    if (!ofNode && haptic.has("tolerance")) unusedHaptics_.add("tolerance");
    return true;
  }

  std::uint64_t systemBits(const std::vector<std::string>& names, const JsonObject& place) {
    std::uint64_t bits = 0;
    for (const std::string& name : names) {
      // Bit 0 is for parts that belong to no named system.
      const auto bit = systems_.emplace(name, systems_.size() + 1).first->second;
      if (bit > 63) throw GltfError(place.place(), "more than 63 collision systems are not supported");
      bits |= std::uint64_t{1} << bit;
    }
    return bits;
  }

  CollisionFilter readFilter(const JsonObject& entry) {
    CollisionFilter filter;
    const std::uint64_t member = systemBits(entry.texts("collisionSystems"), entry);
    if (member != 0) filter.memberOf = member;
    if (entry.has("collideWithSystems"))
      filter.collidesWith = systemBits(entry.texts("collideWithSystems"), entry);
    else if (entry.has("notCollideWithSystems"))
      filter.collidesWith = ~systemBits(entry.texts("notCollideWithSystems"), entry);
    return filter;
  }

  void readBodiesSection(const char* extension, Section& materials, Section& filters) {
    materials.first = out_.surfaces.size();
    filters.first = out_.filters.size();
    if (const auto object = extensionOf(json_, extension, "extensions")) {
      for (const JsonObject& material : object->objects("physicsMaterials")) {
        PhysicsSurface surface;
        surface.staticFriction = material.sizeOr("staticFriction", 0.6);
        surface.dynamicFriction = material.sizeOr("dynamicFriction", 0.6);
        surface.restitution = std::min(1.0, material.sizeOr("restitution", 0.0));
        checkContact(surface, material.place());
        readHaptic(material.raw(), material.place(), surface, false);
        out_.surfaces.push_back(surface);
      }
      for (const JsonObject& filter : object->objects("collisionFilters"))
        out_.filters.push_back(readFilter(filter));
    }
    materials.count = out_.surfaces.size() - materials.first;
    filters.count = out_.filters.size() - filters.first;
  }

  // --- joints and gravity

  std::uint8_t readAxes(const JsonObject& limit, const char* key) {
    const Json& axes = limit.raw(key);
    if (!axes.isArray() || axes.size() == 0 || axes.size() > 3)
      limit.fail(key, "must name one to three axes");
    std::uint8_t bits = 0;
    for (const Json& axis : axes) {
      if (!axis.isNatural() || axis.integer() > 2) limit.fail(key, "axes are 0, 1 and 2");
      bits = static_cast<std::uint8_t>(bits | 1u << axis.integer());
    }
    return bits;
  }

  JointLimit readLimit(const JsonObject& entry) {
    JointLimit limit;
    limit.angular = entry.has("angularAxes");
    if (limit.angular == entry.has("linearAxes"))
      entry.fail("linearAxes", "needs either linearAxes or angularAxes");
    limit.axes = readAxes(entry, limit.angular ? "angularAxes" : "linearAxes");
    limit.min = entry.numberOr("min", -1e300);
    limit.max = entry.numberOr("max", 1e300);
    if (limit.min > limit.max) entry.fail("min", "is larger than max");
    limit.stiffness = entry.sizeOr("stiffness", 0.0);
    limit.damping = entry.sizeOr("damping", 0.0);
    return limit;
  }

  JointDrive readDrive(const JsonObject& entry) {
    JointDrive drive;
    drive.angular = entry.choice<bool>("type", "", kAxisNames);
    drive.acceleration = entry.choice<bool>("mode", "", kModeNames);
    drive.axis = static_cast<std::uint8_t>(entry.requiredIndex("axis", 3, "axes"));
    drive.maxForce = entry.sizeOr("maxForce", 1e300);
    drive.positionTarget = entry.numberOr("positionTarget", 0.0);
    drive.velocityTarget = entry.numberOr("velocityTarget", 0.0);
    drive.stiffness = entry.sizeOr("stiffness", 0.0);
    drive.damping = entry.sizeOr("damping", 0.0);
    return drive;
  }

  /// Reads the properties that the extensions lack: a thread, and detents.
  void readHaptic(const JsonObject& entry, PhysicsJoint& joint) {
    const auto extras = entry.object("extras");
    const auto haptic = extras ? extras->object("haptic") : std::nullopt;
    if (!haptic) return;
    joint.pitch = haptic->numberOr("pitch", 0.0);
    const auto detents = haptic->object("detents");
    if (!detents) return;
    joint.detentsTurn = detents->choice<bool>("type", "", kAxisNames);
    const std::size_t size = detents->count("positions");
    if (size == 0 || size > kMaxDetents) detents->fail("positions", "must be one to 4096 numbers");
    joint.detents.places = detents->numbers("positions", size).value();
    joint.detents.force = detents->sizeOr("force", 0.0);
    joint.detents.width = detents->sizeOr("width", 0.0);
    for (std::size_t i = 1; i < size; ++i)
      if (!(joint.detents.places[i] > joint.detents.places[i - 1])) detents->fail("positions", "must ascend");
    if (size == 1 && !(joint.detents.width > 0.0))
      detents->fail("width", "is missing: a single detent has no neighbour to take it from");
  }

  void readJoints(const char* extension, Section& section) {
    section.first = out_.joints.size();
    if (const auto object = extensionOf(json_, extension, "extensions"))
      for (const JsonObject& entry : object->objects("physicsJoints")) {
        PhysicsJoint joint;
        for (const JsonObject& limit : entry.objects("limits")) joint.limits.push_back(readLimit(limit));
        for (const JsonObject& drive : entry.objects("drives")) joint.drives.push_back(readDrive(drive));
        readHaptic(entry, joint);
        out_.joints.push_back(std::move(joint));
      }
    section.count = out_.joints.size() - section.first;
  }

  void readGravity() {
    const auto object = extensionOf(json_, "OMI_physics_gravity", "extensions");
    if (!object) return;
    const glm::dvec3 direction = object->vector("direction").value_or(glm::dvec3(0.0, -1.0, 0.0));
    const double length = glm::length(direction);
    if (!(length > 0.0) || !std::isfinite(length)) object->fail("direction", "must not be zero");
    out_.gravity = direction / length * object->numberOr("gravity", 0.0);
    refuseFault(gravityFault(*out_.gravity), object->place());
  }

  // --- nodes

  PhysicsMotion readMotion(const JsonObject& entry, bool omi) {
    PhysicsMotion motion;
    motion.kinematic = entry.flag("isKinematic", false);
    if (omi) {
      const std::string type = entry.text("type", "");
      if (type != "kinematic" && type != "dynamic")
        entry.fail("type", "must be static, kinematic or dynamic");
      motion.kinematic = type == "kinematic";
      motion.mass = 1.0;
    }
    if (entry.has("mass")) motion.mass = entry.sizeOr("mass", 0.0);
    motion.centreOfMass = entry.vector("centerOfMass");
    motion.inertiaDiagonal = entry.vector("inertiaDiagonal");
    if (motion.inertiaDiagonal &&
        std::min({motion.inertiaDiagonal->x, motion.inertiaDiagonal->y, motion.inertiaDiagonal->z}) < 0.0)
      entry.fail("inertiaDiagonal", "must not be negative");
    // Three zeros mean "compute it" in OMI and "infinite" in KHR.
    if (omi && motion.inertiaDiagonal == glm::dvec3(0.0)) motion.inertiaDiagonal.reset();
    if (const auto q = entry.numbers("inertiaOrientation", 4)) {
      const glm::dquat orientation((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
      const double length = glm::length(orientation);
      if (!(length > 1e-9 && length < 1e9)) entry.fail("inertiaOrientation", "is not a rotation");
      motion.inertiaOrientation = orientation / length;
    }
    motion.gravityFactor = entry.numberOr("gravityFactor", 1.0);
    refuseFault(gravityFactorFault(motion.gravityFactor), entry.place());
    return motion;
  }

  void setShape(PhysicsCollider& collider, std::size_t shape) {
    if (out_.shapes[shape].mesh)
      collider.mesh = out_.shapes[shape].mesh;
    else
      collider.shape = shape;
  }

  PhysicsCollider readCollider(const JsonObject& entry, const Section& shapes, const Section& materials,
                               const Section& filters, bool omi) {
    PhysicsCollider collider;
    const auto geometry = entry.object("geometry");
    const JsonObject& holder = geometry ? *geometry : entry;
    if (!geometry && !omi) ++oldForms_;
    if (const auto shape = holder.index("shape", shapes.count, "shapes"))
      setShape(collider, shapes.first + *shape);
    else if (const auto node = holder.index("node", document_.model.nodes.size(), "nodes"))
      collider.node = *node;
    else if (const auto mesh = holder.index("mesh", document_.model.meshes.size(), "meshes"))
      collider.mesh = *mesh;
    else
      holder.fail("shape", "is missing");
    if (holder.flag("convexHull", false)) ++hulls_;
    if (const auto material = entry.index("physicsMaterial", materials.count, "physics materials"))
      collider.surface = materials.first + *material;
    if (const auto filter = entry.index("collisionFilter", filters.count, "collision filters"))
      collider.filter = filters.first + *filter;
    return collider;
  }

  PhysicsJointUse readJointUse(const JsonObject& entry, const Section& joints) {
    PhysicsJointUse use;
    use.joint = joints.first + entry.requiredIndex("joint", joints.count, "physics joints");
    use.connectedNode = entry.requiredIndex("connectedNode", document_.model.nodes.size(), "nodes");
    use.collide = entry.flag("enableCollision", false);
    return use;
  }

  /// extras.haptic.tolerance of a node, m; 0 where it states none.
  static double readTolerance(const Json& node, const std::string& place) {
    const Json& value = node.member("extras").member("haptic");
    if (value.isAbsent()) return 0.0;
    const JsonObject haptic(value, place + ".extras.haptic");
    const std::optional<double> tolerance = haptic.number("tolerance");
    if (tolerance) refuseFault(toleranceFault(*tolerance), haptic.place());
    return tolerance.value_or(0.0);
  }

  /// extras.cad.density of a node, kg/m^3; 0 where it states none that a material could have. Other programs
  /// too may write an extras.cad, so nothing in it is refused.
  static double readDensity(const Json& node) {
    const Json& density = node.member("extras").member("cad").member("density");
    if (!density.isNumber()) return 0.0;
    return density.number() > kLeastDensity && density.number() < kMostDensity ? density.number() : 0.0;
  }

  void readNode(const Json& value, std::size_t index) {
    PhysicsNode& node = out_.nodes[index];
    const std::string place = placeName("nodes", index);
    node.contactTolerance = readTolerance(value, place);
    node.density = readDensity(value);
    PhysicsSurface surface;
    if (readHaptic(value, place, surface, true)) {
      node.hapticSurface = out_.surfaces.size();
      out_.surfaces.push_back(surface);
    }
    if (const auto khr = extensionOf(value, "KHR_physics_rigid_bodies", place)) {
      if (const auto motion = khr->object("motion")) node.motion = readMotion(*motion, false);
      if (const auto collider = khr->object("collider"))
        node.collider = readCollider(*collider, khrShapes_, khrMaterials_, khrFilters_, false);
      if (const auto joint = khr->object("joint")) node.joint = readJointUse(*joint, khrJoints_);
      if (khr->has("trigger")) ++triggers_;
    }
    if (const auto omi = extensionOf(value, "OMI_physics_body", place)) {
      const auto motion = omi->object("motion");
      if (motion && motion->text("type", "") != "static") node.motion = readMotion(*motion, true);
      // OMI bodies use KHR's lists of materials and filters where the file has no OMI list.
      if (const auto collider = omi->object("collider"))
        node.collider =
            readCollider(*collider, omiShapes_, omiMaterials_.count > 0 ? omiMaterials_ : khrMaterials_,
                         omiFilters_.count > 0 ? omiFilters_ : khrFilters_, true);
      if (omi->has("trigger")) ++triggers_;
    }
    if (const auto omi = extensionOf(value, "OMI_physics_joint", place))
      node.joint = readJointUse(*omi, omiJoints_);
  }

  const GltfDocument& document_;
  const Json& json_;
  GltfPhysics out_;
  Section khrShapes_, omiShapes_, khrMaterials_, omiMaterials_, khrFilters_, omiFilters_, khrJoints_,
      omiJoints_;
  std::map<std::string, std::size_t> systems_;
  std::uint64_t triggers_ = 0, hulls_ = 0, oldForms_ = 0;
  UnknownProperties unusedHaptics_;
};

}  // namespace

GltfPhysics readPhysics(const GltfDocument& document) { return PhysicsReader(document).read(); }

}  // namespace tandem::assets
