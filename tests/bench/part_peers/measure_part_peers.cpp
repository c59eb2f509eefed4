#include "tests/bench/part_peers/measure_part_peers.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>

#include "client/report/part_experiment.h"
#include "client/report/part_sweep.h"
#include "haptics/measure/held_depth.h"
#include "tests/bench/part_peers/part_peer.h"

namespace tandem::bench {
namespace {

namespace report = client::report;

using Maker = std::unique_ptr<PartPeer> (*)(const assets::Mesh&, const assets::Mesh&);
constexpr Maker kMakers[] = {fclPartPeer, bulletPartPeer, odePartPeer};

// Of large meshes, tens of milliseconds a query, two ticks in a row of so many are looked at.
constexpr std::size_t kEvery = 8, kEveryQuick = 16, kLarge = 9'000;

double cpuMicroseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// Poses of the path, and how deep the part is in the other one there; below 0 where that is not asked.
std::vector<double> exactDepths(const report::PartExperiment& e, const std::vector<bool>& asked) {
  const haptics::ContactScene contact(e.scene, 1);
  haptics::HeldPartDepthMeter meter(contact, report::kHeldPart);
  std::vector<Pose> poses;
  for (const assets::Part& part : e.scene.parts) poses.push_back(part.worldFromPart);
  std::vector<double> depths(e.path.size(), -1.0);
  for (std::size_t i = 0; i < e.path.size(); ++i) {
    if (!asked[i] || !e.path[i].depth) continue;
    poses[report::kHeldPart].position = e.path[i].goal;
    depths[i] = std::max(0.0, meter.measure(poses).depth);
  }
  return depths;
}

report::PartSample sampleOf(const report::PartExperiment& e, std::size_t i, double exactDepth,
                            PartPeer& peer) {
  Pose pose = e.scene.parts[report::kHeldPart].worldFromPart;
  pose.position = e.path[i].goal;
  report::PartSample out;
  PeerContacts found;
  for (int run = 0; run < 2; ++run) {
    const double begin = cpuMicroseconds();
    found = peer.contacts(pose);
    const double took = cpuMicroseconds() - begin;
    out.us = run == 0 ? took : std::min(out.us, took);
  }
  const double length = glm::length(found.normal);
  if (found.count > 0 && length > 0.0) out.normal = found.normal / length;
  out.force = e.stiffness * found.depth * out.normal;
  if (exactDepth >= 0.0) out.depth = std::abs(found.depth - exactDepth);
  return out;
}

report::PartMeasurement measure(const report::PartExperiment& e, const std::vector<bool>& asked,
                                const std::vector<double>& exact, PartPeer& peer) {
  report::PartMeasurement out;
  out.setting = peer.id();
  out.name = peer.name();
  out.kind = report::Kind::peer;
  std::vector<report::PartSample> samples(e.path.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].us = -1.0;
    if (asked[i]) samples[i] = sampleOf(e, i, exact[i], peer);
  }
  report::judgePart(e, {samples}, out);
  return out;
}

}  // namespace

std::vector<std::string> partPeerVersions() {
  assets::Mesh nothing;
  nothing.positions = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  nothing.triangles = {{0, 1, 2}};
  std::vector<std::string> versions;
  for (const Maker make : kMakers)
    if (const std::unique_ptr<PartPeer> peer = make(nothing, nothing)) versions.push_back(peer->version());
  return versions;
}

report::PartExperimentResult measurePartPeers(const report::ExperimentInfo& info,
                                              const report::SweepOptions& options) {
  const report::PartExperiment e =
      report::buildPartExperiment(info.id, report::partTicksOf(options), options.quick);
  report::PartExperimentResult result;
  result.info = e.info;
  const bool large = assets::triangleCount(e.scene) > kLarge;
  const std::size_t every = !large ? 1 : options.quick ? kEveryQuick : kEvery;
  std::vector<bool> asked(e.path.size());
  // Where there is something to find; elsewhere boxes apart cost nothing.
  for (std::size_t i = 0; i < asked.size(); ++i) asked[i] = e.path[i].contact && i % every < 2;
  const std::vector<double> exact = exactDepths(e, asked);
  for (const Maker make : kMakers) {
    const auto start = std::chrono::steady_clock::now();
    const std::unique_ptr<PartPeer> peer =
        make(e.scene.meshes[report::kHeldPart], e.scene.meshes[report::kOtherPart]);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    if (peer == nullptr) continue;
    result.settings.push_back(measure(e, asked, exact, *peer));
    result.settings.back().build_ms = took.count();
  }
  return result;
}

}  // namespace tandem::bench
