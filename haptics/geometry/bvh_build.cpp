#include "haptics/geometry/bvh_build.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <span>

#include <glm/common.hpp>

#include "assets/base/assert.h"
#include "haptics/base/in_parallel.h"
#include "haptics/base/simd4.h"
#include "haptics/geometry/outward.h"

namespace tandem::haptics {
namespace {

using Node = TriangleBvh::Node;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kMaxBins = 16;
constexpr std::uint32_t kGrain = 8192;  // primitives below which a single thread builds a subtree
constexpr int kMedianDepth = 36;        // binary levels after which splits halve, which bounds the depth

/// A box of four floats a side; the fourth lane may carry a primitive's index and is never compared.
struct Box4 {
  Float4 low{kInfinity}, high{-kInfinity};
  void grow(Float4 l, Float4 h) {
    low = min(low, l);
    high = max(high, h);
  }
  void grow(const Box4& other) { grow(other.low, other.high); }
};

float halfArea(const Box4& box) {
  alignas(16) float e[4];
  (box.high - box.low).store(e);
  return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
}

/// Primitives [begin, end) and their box.
struct Range {
  std::uint32_t begin = 0, end = 0;
  Box4 box;
  int depth = 0;  // binary splits above
  std::uint32_t size() const { return end - begin; }
};

void grow(Range& range, const BuildPrimitive& p) {
  range.box.grow(Float4::load(p.low), Float4::load(p.high));
}

struct Bin {
  Box4 box;
  std::uint32_t count = 0;

  void add(const BuildPrimitive& p) {
    box.grow(Float4::load(p.low), Float4::load(p.high));
    ++count;
  }
  void add(const Bin& other) {
    box.grow(other.box);
    count += other.count;
  }
};

/// The bins of a range along one axis, over its box. Bins over the box of the centres would be filled better,
/// but tracking that box costs an eighth of the build and saves a point tool only 3 % of its tick.
struct Binning {
  int axis = 0, count = 0;
  float low = 0.0f, scale = 0.0f;  // of doubled centres

  int of(const BuildPrimitive& p) const {
    return std::min(count - 1, static_cast<int>((p.low[axis] + p.high[axis] - low) * scale));
  }
};

struct Bins {
  Bin bin[kMaxBins];
};

class Builder {
 public:
  explicit Builder(std::span<BuildPrimitive> primitives) : primitives_(primitives) {}

  /// Splits a range into up to four and writes their boxes. children[i] is a leaf, or is to be built from
  /// ranges[i].
  int makeNode(const Range& range, Node& node, std::array<Range, 4>& ranges) const {
    ranges[0] = range;
    int count = 1;
    while (count < 4) {
      int widest = -1;
      float area = -1.0f;
      for (int i = 0; i < count; ++i) {
        const float a = halfArea(ranges[i].box);
        // Boxes beyond the range of a float have no area to compare.
        if (ranges[i].size() > TriangleBvh::kMaxLeaf && (widest < 0 || a > area)) {
          widest = i;
          area = a;
        }
      }
      if (widest < 0) break;
      const Range whole = ranges[widest];
      split(whole, ranges[widest], ranges[count]);
      ++count;
    }
    for (int i = 0; i < 4; ++i) setChild(node, i, i < count ? &ranges[i] : nullptr);
    return count;
  }

  /// Builds the subtree of a range into `nodes`; returns the index of its root.
  std::uint32_t buildSerial(const Range& range, std::vector<Node>& nodes) const {
    const std::uint32_t index = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    std::array<Range, 4> ranges;
    Node node;
    const int count = makeNode(range, node, ranges);
    for (int i = 0; i < count; ++i) {
      if (ranges[i].size() > TriangleBvh::kMaxLeaf) node.child[i] = buildSerial(ranges[i], nodes);
    }
    nodes[index] = node;
    return index;
  }

 private:
  static void setChild(Node& node, int i, const Range* range) {
    alignas(16) float low[4] = {kInfinity, kInfinity, kInfinity, 0.0f};
    alignas(16) float high[4] = {-kInfinity, -kInfinity, -kInfinity, 0.0f};
    node.child[i] = TriangleBvh::kEmptyChild;
    if (range != nullptr) {
      range->box.low.store(low);
      range->box.high.store(high);
      node.child[i] = TriangleBvh::kLeafBit | range->size() << 28 | range->begin;
    }
    for (int axis = 0; axis < 3; ++axis) {
      node.low[axis][i] = low[axis];
      node.high[axis][i] = high[axis];
    }
  }

  void split(const Range& whole, Range& left, Range& right) const {
    alignas(16) float low[4], high[4];
    (whole.box.low + whole.box.low).store(low);
    (whole.box.high + whole.box.high).store(high);
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (high[i] - low[i] > high[axis] - low[axis]) axis = i;
    }
    const float width = high[axis] - low[axis];
    // Bins are meaningless where bins per metre, or a box, exceed the range of a float.
    if (!(width > 0x1p-100f && width < 0x1p100f) || whole.depth >= kMedianDepth) {
      return splitAtMedian(whole, axis, left, right);
    }

    const int binCount = std::min<int>(kMaxBins, 4 + static_cast<int>(whole.size() / 4));
    const Binning binning{axis, binCount, low[axis], static_cast<float>(binCount) * (1.0f - 1e-6f) / width};
    Bins bins;
    fill(whole, binning, bins);
    const int at = bestSplit(bins, binCount);
    if (at < 0) return splitAtMedian(whole, axis, left, right);

    left = right = Range{};
    for (int i = 0; i < binCount; ++i) {
      Range& side = i < at ? left : right;
      side.box.grow(bins.bin[i].box);
    }
    finish(whole, partition(whole, binning, at), left, right);
  }

  /// Neighbours in the list mostly fall into the same bin. Two alternating sets of bins halve the stall on
  /// the previous store.
  void fill(const Range& whole, const Binning& binning, Bins& bins) const {
    std::uint32_t i = whole.begin;
    if (whole.size() >= 64) {
      Bins odd;
      for (; i + 1 < whole.end; i += 2) {
        const BuildPrimitive &p = primitives_[i], &q = primitives_[i + 1];
        bins.bin[binning.of(p)].add(p);
        odd.bin[binning.of(q)].add(q);
      }
      for (int k = 0; k < binning.count; ++k) bins.bin[k].add(odd.bin[k]);
    }
    for (; i < whole.end; ++i) bins.bin[binning.of(primitives_[i])].add(primitives_[i]);
  }

  /// Moves the bins below `at` to the front and returns where the others begin. The side of a primitive is
  /// unpredictable, so an unconditional exchange (Lomuto's partition) is faster than a branch.
  std::uint32_t partition(const Range& whole, const Binning& binning, int at) const {
    std::uint32_t middle = whole.begin;
    for (std::uint32_t i = whole.begin; i < whole.end; ++i) {
      BuildPrimitive &p = primitives_[i], &q = primitives_[middle];
      middle += binning.of(p) < at ? 1u : 0u;
      const Float4 pLow = Float4::load(p.low), pHigh = Float4::load(p.high);
      const Float4 qLow = Float4::load(q.low), qHigh = Float4::load(q.high);
      qLow.store(p.low);
      qHigh.store(p.high);
      pLow.store(q.low);
      pHigh.store(q.high);
    }
    return middle;
  }

  /// The first bin of the right side with the least surface-area cost, or -1 if one side would be empty.
  static int bestSplit(const Bins& bins, int binCount) {
    std::array<float, kMaxBins> rightCost;
    Box4 box;
    std::uint32_t count = 0;
    for (int i = binCount - 1; i > 0; --i) {
      const Bin& bin = bins.bin[i];
      if (bin.count > 0) box.grow(bin.box);
      count += bin.count;
      rightCost[static_cast<std::size_t>(i)] = count > 0 ? halfArea(box) * static_cast<float>(count) : -1.0f;
    }
    int best = -1;
    float bestCost = kInfinity;
    box = Box4{};
    count = 0;
    for (int i = 1; i < binCount; ++i) {
      const Bin& bin = bins.bin[i - 1];
      if (bin.count > 0) box.grow(bin.box);
      count += bin.count;
      const float right = rightCost[static_cast<std::size_t>(i)];
      if (count == 0 || right < 0.0f) continue;
      const float cost = halfArea(box) * static_cast<float>(count) + right;
      if (cost < bestCost) {
        bestCost = cost;
        best = i;
      }
    }
    return best;
  }

  void splitAtMedian(const Range& whole, int axis, Range& left, Range& right) const {
    const std::uint32_t middle = whole.begin + whole.size() / 2;
    const auto key = [axis](const BuildPrimitive& p) {
      const float sum = p.low[axis] + p.high[axis];
      return std::isnan(sum) ? 0.0f : sum;  // minus plus plus infinity is NaN; an order needs numbers
    };
    std::nth_element(primitives_.begin() + whole.begin, primitives_.begin() + middle,
                     primitives_.begin() + whole.end, [&](const BuildPrimitive& a, const BuildPrimitive& b) {
                       return key(a) != key(b) ? key(a) < key(b) : a.triangle() < b.triangle();
                     });
    left = right = Range{};
    for (std::uint32_t i = whole.begin; i < whole.end; ++i) grow(i < middle ? left : right, primitives_[i]);
    finish(whole, middle, left, right);
  }

  static void finish(const Range& whole, std::uint32_t middle, Range& left, Range& right) {
    left.begin = whole.begin;
    left.end = right.begin = middle;
    right.end = whole.end;
    left.depth = right.depth = whole.depth + 1;
  }

  std::span<BuildPrimitive> primitives_;
};

/// A subtree as one unit of work. A large one becomes a node with four more tasks; a small one is built
/// whole.
struct Task {
  Range range;
  Node node;
  std::array<std::unique_ptr<Task>, 4> children;
  std::vector<Node> nodes;  // of a subtree built whole
  std::uint32_t first = 0;  // position of its nodes in the tree
};

class TaskPool {
 public:
  TaskPool(const Builder& builder, Task* root) : builder_(builder), open_(1) { queue_.push_back(root); }

  void run(int threads) {
    onThreads(threads, [this](int) { work(); });
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return !queue_.empty() || open_ == 0; });
      if (open_ == 0) return;
      Task* task = queue_.front();
      queue_.pop_front();
      lock.unlock();
      build(*task);
      lock.lock();
      for (const auto& child : task->children) {
        if (child) {
          queue_.push_back(child.get());
          ++open_;
        }
      }
      --open_;
      changed_.notify_all();
    }
  }

  void build(Task& task) const {
    if (task.range.size() <= kGrain) {
      task.nodes.reserve(task.range.size() / 4 + 1);
      builder_.buildSerial(task.range, task.nodes);
      return;
    }
    std::array<Range, 4> ranges;
    const int count = builder_.makeNode(task.range, task.node, ranges);
    for (int i = 0; i < count; ++i) {
      if (ranges[i].size() <= TriangleBvh::kMaxLeaf) continue;
      task.children[i] = std::make_unique<Task>();
      task.children[i]->range = ranges[i];
    }
  }

  const Builder& builder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task*> queue_;
  std::size_t open_;
};

/// Assigns the position of every task's nodes, depth first. The order does not depend on the threads that
/// built them.
void place(Task& task, std::uint32_t& next, std::vector<Task*>& all) {
  task.first = next;
  all.push_back(&task);
  next += task.nodes.empty() ? 1u : static_cast<std::uint32_t>(task.nodes.size());
  for (int i = 0; i < 4; ++i) {
    if (!task.children[i]) continue;
    place(*task.children[i], next, all);
    task.node.child[i] = task.children[i]->first;
  }
}

void copyOut(const Task& task, Node* nodes) {
  if (task.nodes.empty()) {
    nodes[task.first] = task.node;
    return;
  }
  Node* out = nodes + task.first;
  for (const Node& from : task.nodes) {
    Node& node = *out++ = from;
    for (std::uint32_t& child : node.child) {
      if ((child & TriangleBvh::kLeafBit) == 0) child += task.first;
    }
  }
}

/// The primitives of triangles [begin, end), and their range's boxes.
Range makePrimitives(const assets::Mesh& mesh, const glm::dvec3& centre, std::size_t begin, std::size_t end,
                     BuildPrimitive* primitives) {
  Range range;
  for (std::size_t i = begin; i < end; ++i) {
    const auto& t = mesh.triangles[i];
    const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const glm::dvec3 low = glm::min(a, glm::min(b, c)) - centre, high = glm::max(a, glm::max(b, c)) - centre;
    BuildPrimitive& p = primitives[i];
    for (int axis = 0; axis < 3; ++axis) {
      p.low[axis] = roundDown(low[axis]);
      p.high[axis] = roundUp(high[axis]);
    }
    p.setTriangle(static_cast<std::uint32_t>(i));
    p.high[3] = 1.0f;
    grow(range, p);
  }
  return range;
}

}  // namespace

BuiltTree buildTree(const assets::Mesh& mesh, const glm::dvec3& centre, int threads) {
  const std::size_t count = mesh.triangles.size();
  ASSERT(threads >= 1 && count > 0);
  // The array is not zeroed first, so that all threads touch its pages.
  const auto primitives = std::make_unique_for_overwrite<BuildPrimitive[]>(count);
  std::vector<Range> shares(static_cast<std::size_t>(threads));
  inParallel(count, threads, [&](std::size_t begin, std::size_t end, int worker) {
    shares[static_cast<std::size_t>(worker)] = makePrimitives(mesh, centre, begin, end, primitives.get());
  });
  Task root;
  root.range.end = static_cast<std::uint32_t>(count);
  for (const Range& share : shares) {
    root.range.box.grow(share.box);
  }
  const Builder builder(std::span(primitives.get(), count));
  TaskPool(builder, &root).run(threads);

  std::vector<Task*> tasks;
  std::uint32_t nodeCount = 0;
  place(root, nodeCount, tasks);
  BuiltTree tree{std::make_unique_for_overwrite<Node[]>(nodeCount), nodeCount, {}};
  ASSERT(nodeCount > 0);
  tree.order.resize(count);
  std::atomic<std::size_t> next{0};
  inParallel(count, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) tree.order[i] = primitives[i].triangle();
    for (std::size_t i = next++; i < tasks.size(); i = next++) {
      copyOut(*tasks[i], tree.nodes.get());
      std::vector<Node>().swap(tasks[i]->nodes);
    }
  });
  return tree;
}

}  // namespace tandem::haptics
