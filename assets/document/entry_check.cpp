#include "assets/document/entry_check.h"

#include <cmath>

#include "assets/base/finite.h"
#include "assets/base/printable.h"
#include "assets/document/describe.h"

namespace tandem::document {
namespace {

/// Finds the first field that breaks its limit, and adds up what the body takes.
class Checker {
 public:
  std::string problem;
  std::size_t bytes = 1;
  EntryId refersTo = 0;

  void text(const char* name, const std::string& value, std::size_t limit) {
    bytes += 2 + value.size();
    if (value.size() > limit) fail(name, "is longer than " + std::to_string(limit) + " bytes");
    if (!isPrintable(value)) fail(name, "is not printable UTF-8");
  }
  void real(const char* name, double value, double least, double most) {
    bytes += 8;
    if (!(value >= least && value <= most)) fail(name, "is out of range");
  }
  void vector(const char* name, const glm::dvec3& value) {
    bytes += 24;
    if (!isNear(value)) fail(name, "is out of range");
  }
  void pose(const char* name, const Pose& value) {
    bytes += 56;
    if (!isNear(value.position) || !isValid(value)) fail(name, "is not a pose");
  }
  void flag(const char*, bool) { ++bytes; }
  void part(const char* name, PartId value, Needed needed) {
    bytes += 2;
    const bool none = value == kNoPart && needed == Needed::no;
    if (value >= kMaxParts && !none) fail(name, "is no part");
  }
  void entry(const char* name, EntryId value) {
    bytes += 8;
    refersTo = value;
    if (value == 0) fail(name, "names no entry");
  }
  template <typename E, std::size_t N>
  void choice(const char* name, E value, const std::array<const char*, N>&) {
    ++bytes;
    if (static_cast<std::size_t>(value) >= N) fail(name, "is out of range");
  }
  void parts(const char* name, const std::vector<PartId>& values, std::size_t limit) {
    bytes += 2;
    if (values.size() > limit) return fail(name, "has more than " + std::to_string(limit) + " parts");
    for (const PartId value : values) part(name, value, Needed::yes);
  }
  template <typename T>
  void list(const char* name, const std::vector<T>& values, std::size_t limit) {
    bytes += 2;
    if (values.size() > limit) return fail(name, "has more than " + std::to_string(limit) + " elements");
    for (const T& value : values) fields(*this, value);
  }
  template <typename T>
  void addition(const char*, const T& value, bool another) {
    if (value != T{} || another) fields(*this, value);
  }

 private:
  static bool isNear(const glm::dvec3& v) {
    return isFinite(v) && std::abs(v.x) <= kFarthest && std::abs(v.y) <= kFarthest &&
           std::abs(v.z) <= kFarthest;
  }
  void fail(const char* name, const std::string& what) {
    if (problem.empty()) problem = std::string(name) + " " + what;
  }
};

Checker checked(const Body& body) {
  Checker checker;
  std::visit([&](const auto& b) { fields(checker, b); }, body);
  return checker;
}

}  // namespace

Status check(const Body& body) {
  const Checker checker = checked(body);
  if (!checker.problem.empty()) return Error{std::string(kKindNames[body.index()]) + ": " + checker.problem};
  ASSERT(checker.bytes <= kMaxBodyBytes);
  return {};
}

std::size_t sizeOf(const Body& body) { return checked(body).bytes; }
EntryId reference(const Body& body) { return checked(body).refersTo; }

}  // namespace tandem::document
