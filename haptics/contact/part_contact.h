#pragma once

// The parts that a site moves among their neighbours: where each may go in one tick.
//
// A moving part is a god object with mass: it goes where its momentum, the hand's spring, gravity, joints and contacts
// together take it, and never into a neighbour. A tick takes up to kMostSteps steps; each gathers the samples that
// could touch within its reach, of each part of a pair in the field of the other, and solves for the displacements of
// all (contact_solver.h). No step is longer than its reach, so that nothing that was not looked at is passed through;
// what is left of a fast motion is made up in the next ticks. Parts that can neither touch each other nor hang together
// by joints are islands: each is solved by itself, so that a fast or jammed one does not slow the others.
//
// 1. Free of allocation after construction. One a TickState; only where a scene has part models or joints.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "haptics/base/contact_effort.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/contact/contact_solver.h"
#include "haptics/contact/joint_rows.h"
#include "haptics/contact/touching_feature.h"
#include "haptics/scene/contact_world.h"
#include "haptics/scene/part_model.h"

namespace tandem::haptics {

/// A part that moves in this tick, and where it would go.
struct MovingPart {
  PartId part = kNoPart;
  CoupledStep step;
  RigidBody* body = nullptr;
  Displacement way;  // of its centre of mass, and its turn: the answer
};

/// A place where a moving part rests on another.
struct PartTouch {
  PartId of = kNoPart;               // the moving part
  PartId part = kNoPart;             // the other one, which may move too
  glm::dvec3 point{0.0, 0.0, 0.0};   // m, world
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, world, away from `part`
  double force = 0.0;                // N along the normal
};

class PartContact final : public RowRefiner {
 public:
  static constexpr int kMostSteps = 4;
  static constexpr int kMostTouches = 24;
  /// A part that goes less than this share of its size in a second is at rest.
  static constexpr double kRestShare = 3e-3;

  /// Of one tick, for reports.
  struct Work {
    int steps = 0, planes = 0, balls = 0, exact = 0, picks = 0, infeasible = 0, neighbours = 0;
    bool overflow = false;   // rows or neighbours were dropped
    bool exhausted = false;  // the step was cut short because there was more to look at than a tick allows
  };

  explicit PartContact(const ContactWorld& world);

  /// Whether anything tells where a part may go: a model of its shape, or a joint.
  bool constrains(PartId part) const { return world_.model(part) != nullptr || joined(part); }
  bool collides(PartId part) const { return world_.model(part) != nullptr; }
  bool joined(PartId part) const { return part < jointsOf_.size() && !jointsOf_[part].empty(); }
  /// Calls f(other) with each part that a joint ties to this one.
  template <typename F>
  void forEachJoined(PartId part, const F& f) const {
    if (!joined(part)) return;
    for (const std::uint32_t index : jointsOf_[part]) {
      const assets::Joint& joint = *joints_[index].joint;
      const PartId other = joint.partA == part ? joint.partB : joint.partA;
      if (other != kNoPart) f(other);
    }
  }

  /// A part is moved here from now on, from where the world has it. Overlaps that it has with its neighbours are
  /// remembered: it may stay as deep in each, and no deeper, until it has come out. A part that lies wholly inside
  /// another is brought out of it the nearest way.
  void take(PartId part, const glm::dvec3& centreOfMass);

  /// Moves all parts that move here by one step as far as their neighbours and joints let them, and gives each body
  /// the velocity of its motion. At most kMostBodies.
  void move(std::span<MovingPart> moving, double dt, const ContactEffort& effort = {});

  /// Whether something moves beside a part that is at rest here, or a part that it is joined to.
  bool disturbed(PartId part) const;

  /// The strongest of the last tick, strongest first.
  std::span<const PartTouch> touches() const {
    return {touches_.data(), static_cast<std::size_t>(touchCount_)};
  }
  const Work& work() const { return work_; }
  /// Where a joint of the scene stands: m along its X axis, or rad about it with whole turns counted. As of the last
  /// tick in which one of its parts moved here.
  double jointValue(std::uint32_t joint, bool angular) const;

  void refine(RowSource source, const Displacement& u, ContactRows& rows) override;
  glm::dvec3 surfaceMotion(const ExactRow& row) const override;

 private:
  /// What the last close look at a sample told.
  struct Look {
    glm::vec3 place{0.0f, 0.0f, 0.0f};   // m, in the frame of the mesh, relative to its field's origin
    float room = 0.0f;                   // m, that it could go from there without touching; below 0 inside
    std::array<glm::vec3, 2> normals{};  // of the planes that held it, mesh frame
    std::array<float, 2> gaps{};         // m, over those planes
    int planes = 0;
    std::uint32_t triangle = kNoTriangle;  // the nearest one
    PartId other = kNoPart;                // whose
    std::uint32_t step = 0;                // when
  };
  struct Body {
    PartId part = kNoPart;
    const PartModel* model = nullptr;  // null: only joints hold it
    glm::dvec3 centreOfMass{0.0};      // m, part frame
    double radius = 0.0;               // m, about that
    Pose pose;                         // world, now
    glm::dvec3 centre{0.0};            // of mass, m, world
    Displacement goal;                 // of this tick
    double mass = 1.0;                 // kg
    double lastMotion = 0.0;           // m, of the last step of its island
  };
  /// Two parts that may touch, or that a joint holds together. The first one moves here.
  struct Pair {
    int first = 0, second = -1;        // bodies; -1: the other one does not move here
    PartId other = kNoPart;            // kNoPart: the world, of a joint
    const PartModel* model = nullptr;  // of the other one
    Pose otherFromFirst;               // part frames, now
    int overlap = -1;                  // into overlaps_
    double deepest = 0.0;              // m, an upper bound, where there is an overlap
    double push = 0.0;                 // m, that the other one may come in this tick by itself
    double gap = 0.0;                  // m, at least, when the tick began
    std::int32_t joint = -1;           // into joints_; -1: a pair that may touch
  };
  /// The samples of one part of a pair before the other one: `from` them, `to` what is asked.
  struct AskedSide {
    const PartModel* from = nullptr;
    const PartModel* to = nullptr;
    Pose toFromSamples, worldFromTo;
    glm::mat3 turn{1.0f};   // world from `to`
    glm::vec3 shift{0.0f};  // m, from the reference point to the origin of its field, world axes
    float sign = 1.0f;      // of a normal of `to`, as the first part feels it
    float limit = 0.0f;     // m, reach of the step
    float allowed = 0.0f;   // m, depth that the sample had at rest
    float smooth = 0.0f,
          rough = 0.0f;     // m, errors of the field up to which it is believed, and above which not
    float believed = 0.0f;  // m, how far a sample may go before it is looked at again
    bool contained = false;
    std::uint16_t pair = 0, side = 0;  // 0: of the first part
    PartId sampled = kNoPart, asked = kNoPart;

    bool ofFirst() const { return side == 0; }
    glm::vec3 world(const glm::dvec3& normal) const { return sign * (turn * glm::vec3(normal)); }
    glm::vec3 arm(const glm::dvec3& point) const {
      return turn * glm::vec3(point - to->field.origin()) + shift;
    }
  };
  /// Two parts that were in each other when one was taken.
  struct Overlap {
    PartId a = kNoPart, b = kNoPart;
    double allowed = 0.0;              // m, how deep it may be; shrinks as they come out
    assets::Bounds inA, inB;           // m, part frames: where samples were inside
    double margin = 0.0;               // m, beside them, where nothing is allowed any more
    bool contained = false;            // a is wholly inside b: it is brought out
    glm::dvec3 wayOut{0.0, 0.0, 0.0};  // unit, in the frame of b
  };
  struct Kept {
    PartId first = kNoPart, other = kNoPart;
    RowSource source;
    int unused = 0;  // steps since it last held the part
  };
  /// What is known of the last tick: friction between two parts, and how far a part went.
  struct KeptFriction {
    PartId first = kNoPart, other = kNoPart;
    ContactSolver::Friction friction;
  };
  struct Pace {
    PartId part = kNoPart;
    double motion = 0.0;  // m, of the last step of its island
  };
  struct HeldJoint {
    const assets::Joint* joint = nullptr;
    JointState state;
    bool started = false;
    bool sprung = false;  // it may move parts by itself
    PlacedJoint placed;
  };

  // The parts and pairs of an island.
  using Moving = std::span<MovingPart* const>;
  void gatherBodies(Moving moving);
  /// Puts the parts of an island beside each other, one island after the other; `ends` is where each ends. Returns how
  /// many there are.
  int splitIntoIslands(std::span<MovingPart*> moving, std::array<std::size_t, kMostBodies>& ends) const;
  void moveIsland(Moving moving, int mostPicks);
  int bodyOf(PartId part) const;
  void addBody(PartId part, const glm::dvec3& centreOfMass, const Pose& pose);
  /// Of more than there is room for, those that are nearest.
  void addPair(const Pair& pair);
  /// m, at least, between a part's box and the ball around another; below 0 where they meet.
  double leastGap(const Body& body, const Pose& bodyFromWorld, PartId other) const;
  void findPairs(double reach);
  void findJoints();
  bool mayTouch(PartId a, PartId b) const;
  double pushOf(PartId part) const;
  const Pose& poseOf(const Pair& pair) const;
  /// The friction of the last tick is that of its parts, whatever the numbers of their pairs are now.
  void recallFriction();
  void keepFriction();
  void place();
  static double motionOf(const Body& body, const Displacement& u);
  Displacement left(std::size_t body) const;

  // A step.
  void gather(double reach);
  void addJoints();
  /// Rows of the last steps' contacts, looked at closely from the start: what rests stays at rest. They are aimed at
  /// where the parts are expected to go.
  void refineKept();
  void keepContacts();
  /// Moves the bodies as far as the solver said and the reach allows; true if nothing is left to do.
  bool advance(int step);
  void noteTouches();

  // The samples of one part of a pair before the other: part_sides.cpp.
  AskedSide askedSide(std::uint16_t pair, std::uint16_t side, double reach) const;
  /// m, of overlap at rest.
  double allowedOf(const AskedSide& side, const ContactSample& sample) const;
  /// What is known of a sample before another part; the oldest of what is known of others if nothing is.
  Look& lookAt(PartId part, std::uint32_t sample, PartId other);
  /// Rows of all that could touch within `reach` m.
  void gatherSide(std::uint16_t pair, std::uint16_t side, double reach);
  void addSampleRow(const AskedSide& side, std::uint32_t i, const glm::vec3& place,
                    const DistanceField::Reading& read, float& deepest);
  /// The planes that the last look told, of the sample or of its patch, while they are believed; else how far it may
  /// surely go: `room` m, or more if that look says so.
  void addLookRows(const AskedSide& side, std::uint32_t i, const glm::vec3& place, const ContactPatch* patch,
                   float room);
  /// Whether a piece of edge may come nearer to a surface between its sample and the next one than at both: where it
  /// crosses a blade or a rib that is thin beside the way between them, which both have beside them. To a body that
  /// is convex there the distance is a convex function along the edge, above its tangents.
  static bool crossesBlade(const AskedSide& side, const ContactSample& sample, const glm::vec3& place,
                           const DistanceField::Reading& read);
  /// Where the field is not so good, the face that the sample was last found before tells more, while it still is
  /// before that face.
  void turnToFace(const AskedSide& side, std::uint32_t i, const DistanceField::Reading& read,
                  glm::vec3& normal, float& gap);
  /// `u` is expected of the first part. The answer has no normals yet.
  SampleAtMesh askedSample(const AskedSide& side, const ContactSample& sample, const Displacement& u) const;
  /// False if nothing tells.
  bool holdsOff(const AskedSide& side, const ContactSample& sample, const SampleAtMesh& asked,
                std::uint32_t hint, TouchingFeature& found) const;
  /// What holds a sample off, as the field alone tells it: good to within its error.
  static bool fieldFeature(const PartModel& to, const SampleAtMesh& asked, TouchingFeature& found);
  /// A surface without an inside holds off whatever is before it, on either side.
  static void turnToSample(TouchingFeature& found, const Look* last, double tolerance);
  void keepLook(const AskedSide& side, const ContactSample& sample, const SampleAtMesh& asked,
                const TouchingFeature& found, Look& look) const;
  void addFoundRows(const AskedSide& side, const ContactSample& sample, const TouchingFeature& found,
                    RowSource source, ContactRows& rows);

  // Of parts that are known by formula, and of samples that stand for pieces of round surfaces: part_patches.cpp.
  /// m, by which a place on a patch may be less deep than the deepest.
  static double evenness(const PartModel& to);
  void addShapeRows(const AskedSide& side, std::uint32_t i, float& deepest);
  void addPatchRow(const AskedSide& side, std::uint32_t i, const glm::vec3& place,
                   const DistanceField::Reading& read, float& deepest);
  static bool touchShapes(const PartModel& from, const PartModel& to, const Pose& toFromSamples,
                          const ContactSample& sample, const SampleAtMesh& asked, TouchingFeature& found);
  bool touchPatch(const PartModel& from, const PartModel& to, const Pose& toFromSamples,
                  const ContactSample& sample, SampleAtMesh asked, std::uint32_t hint,
                  TouchingFeature& found) const;
  /// Depth in m of a sample, with its patch, in a part that is known by formula; in any other the place to look at.
  static double depthOf(const PartModel& from, const PartModel& to, const Pose& toFromSamples,
                        const ContactSample& sample, glm::dvec3& deepestPoint);

  // Overlaps: part_overlaps.cpp.
  void noteOverlap(Pair& pair);
  /// Depth in m of the deepest sample of one part in the other, and whether all of them are inside. Those that may be
  /// are added to the bounds.
  double depthOfSide(const Pair& pair, bool ofFirst, bool& allInside, assets::Bounds& inFirst,
                     assets::Bounds& inOther);
  void bringOut(const Pair& pair, std::uint16_t index);
  /// Half a second for the part's own radius: a pull that grows, and no blow.
  double wayOutATick(const Body& body) const { return 2.0 * body.radius * dt_; }
  void updateOverlaps();
  bool isContained(const Pair& pair) const;
  /// m, at most, anywhere.
  double allowedDepth(const Pair& pair) const;
  /// m, of a sample at a place in both part frames: all of it where either part was in the other, else nothing.
  double allowedAt(const Pair& pair, const glm::dvec3& inFirst, const glm::dvec3& inOther) const;

  static constexpr std::uint32_t kFresh = 8;  // steps for which a plane is believed at least
  static constexpr std::uint32_t kLooks =
      2;                                  // others of which a sample is known: an edge often stands on two
  static constexpr int kMostLooks = 400;  // when a part is taken
  static constexpr int kForJoints = 16;   // pairs
  static constexpr int kMostKept = 48, kKeptFor = 16;
  static constexpr int kMostOverlaps = 64;
  static constexpr int kMostFrictions = 2 * ContactSolver::kMostActive;

  const ContactWorld& world_;
  std::vector<std::vector<Look>> looks_;              // a part, kLooks a sample
  std::vector<HeldJoint> joints_;                     // of the scene, but of controls
  std::vector<std::vector<std::uint32_t>> jointsOf_;  // a part; empty without joints
  ContactRows rows_;
  ContactSolver solver_;
  std::array<Body, kMostBodies> bodies_;
  std::array<StepGoal, kMostBodies> goals_;
  int bodyCount_ = 0;
  std::array<Pair, kMostPairs> pairs_;
  std::array<RowPair, kMostPairs> rowPairs_;
  int pairCount_ = 0;
  std::array<KeptFriction, kMostFrictions> friction_, lastFriction_;  // of this tick so far, of the last one
  int frictionCount_ = 0, lastFrictionCount_ = 0;
  std::array<Pace, kMostBodies> pace_, lastPace_;
  int paceCount_ = 0, lastPaceCount_ = 0;
  std::array<Kept, kMostKept> kept_;
  int keptCount_ = 0;
  std::array<Overlap, kMostOverlaps> overlaps_;
  int overlapCount_ = 0;
  int looksAtTaking_ = 0;
  std::array<PartTouch, kMostTouches> touches_;
  int touchCount_ = 0;
  Work work_;

  // Of the present tick, and of its present island.
  ContactEffort effort_;
  double dt_ = 0.0;          // s
  double tolerance_ = 0.0;   // m, the finest of the bodies' models
  double reach_ = 0.0;       // m, of the present step
  double lastMotion_ = 0.0;  // m, of the last step
  double push_ = 0.0;        // m, that neighbours may push in this tick
  std::uint32_t stepNumber_ = 0;
};

}  // namespace tandem::haptics
