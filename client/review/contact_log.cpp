#include "client/review/contact_log.h"

#include <algorithm>
#include <cstdio>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client {

void ContactLog::note(double time, const Pose& device, bool valid, const haptics::TickOutput& tick) {
  ASSERT(tick.contactCount >= 0 && tick.contactCount <= haptics::kMaxContacts);
  std::fill(forceNow_.begin(), forceNow_.end(), -1.0);
  for (int i = 0; i < tick.contactCount; ++i) {
    const haptics::Contact& contact = tick.contacts[static_cast<std::size_t>(i)];
    if (contact.part == kNoPart) continue;
    if (keepsRows_) rows_.push_back({time, contact});
    Touched& entry = entryOf(contact.part);
    double& now = forceNow_[static_cast<std::size_t>(&entry - touched_.data())];
    now = std::max(now, 0.0) + contact.force;
  }
  ASSERT(forceNow_.size() == touched_.size());
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    if (forceNow_[i] < 0.0) continue;
    ++touched_[i].ticks;
    touched_[i].largestForce = std::max(touched_[i].largestForce, forceNow_[i]);
    touched_[i].impulse += forceNow_[i] * dt_;
  }
  fullTicks_ += tick.contactCount == haptics::kMaxContacts ? 1 : 0;
  const bool touching = tick.contactCount > 0;
  if (started_ && valid) {
    const glm::dvec3 displacement = device.position - device_.position;
    const glm::dvec3 rotation = rotationVector(device.orientation * glm::conjugate(device_.orientation));
    const double done = -0.5 * (glm::dot(toHand_.force + tick.hands[0].toHand.force, displacement) +
                                glm::dot(toHand_.torque + tick.hands[0].toHand.torque, rotation));
    work_ += done;
    if (touching || touching_) contactWork_ += done;
  }
  started_ = valid;
  touching_ = touching;
  device_ = device;
  toHand_ = tick.hands[0].toHand;
}

ContactLog::Touched& ContactLog::entryOf(PartId part) {
  const auto found =
      std::find_if(touched_.begin(), touched_.end(), [&](const Touched& t) { return t.part == part; });
  if (found != touched_.end()) return *found;
  forceNow_.push_back(-1.0);
  touched_.push_back({part});
  return touched_.back();
}

std::string ContactLog::csv() const {
  std::string text = "t,part,px,py,pz,nx,ny,nz,force\n";
  char line[256];
  for (const Row& row : rows_) {
    const glm::dvec3 &p = row.contact.point, &n = row.contact.normal;
    std::snprintf(line, sizeof line, "%.9g,", row.time);
    text += line + csvCell(scene_.parts[row.contact.part].name);
    std::snprintf(line, sizeof line, ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", p.x, p.y, p.z, n.x, n.y, n.z,
                  row.contact.force);
    text += line;
  }
  return text;
}

std::string csvCell(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string cell = "\"";
  for (const char c : name) cell.append(c == '"' ? 2 : 1, c);
  return cell + '"';
}

}  // namespace tandem::client
