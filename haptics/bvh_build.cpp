#include "haptics/bvh_build.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "haptics/simd4.h"

namespace tandem::haptics {
namespace {

using Node = TriangleBvh::Node;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kMaxBins = 16;
constexpr std::uint32_t kGrain = 8192;  // primitives below which one thread builds a subtree alone
constexpr int kMedianDepth = 36;        // binary levels after which splits halve, so that depth stays bounded

/// A box of four floats a side; the fourth lane carries the primitive's index bits and is never looked at.
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

/// Primitives [begin, end), their box and the box of their (doubled) centres.
struct Range {
  std::uint32_t begin = 0, end = 0;
  Box4 box, centres;
  int depth = 0;  // binary splits above
  std::uint32_t size() const { return end - begin; }
};

void grow(Range& range, const BuildPrimitive& p) {
  const Float4 low = Float4::load(p.low), high = Float4::load(p.high);
  range.box.grow(low, high);
  const Float4 centre = low + high;
  range.centres.grow(centre, centre);
}

struct Bin {
  Box4 box, centres;
  std::uint32_t count = 0;
};

class Builder {
 public:
  explicit Builder(std::vector<BuildPrimitive>& primitives) : primitives_(primitives) {}

  /// Splits a range into up to four and writes their boxes; children[i] is a leaf, or to be built from
  /// ranges[i].
  int makeNode(const Range& range, Node& node, std::array<Range, 4>& ranges) const {
    ranges[0] = range;
    int count = 1;
    while (count < 4) {
      int widest = -1;
      float area = -1.0f;
      for (int i = 0; i < count; ++i) {
        const float a = halfArea(ranges[i].box);
        if (ranges[i].size() > TriangleBvh::kMaxLeaf && a > area) {
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
    whole.centres.low.store(low);
    whole.centres.high.store(high);
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (high[i] - low[i] > high[axis] - low[axis]) axis = i;
    }
    const float width = high[axis] - low[axis];
    if (!(width > 0.0f) || whole.depth >= kMedianDepth) return splitAtMedian(whole, axis, left, right);

    const int binCount = std::min<int>(kMaxBins, 4 + static_cast<int>(whole.size() / 4));
    std::array<Bin, kMaxBins> bins;
    const float scale = static_cast<float>(binCount) * (1.0f - 1e-6f) / width;
    const auto binOf = [&](const BuildPrimitive& p) {
      return std::min(binCount - 1, static_cast<int>((p.low[axis] + p.high[axis] - low[axis]) * scale));
    };
    for (std::uint32_t i = whole.begin; i < whole.end; ++i) {
      const BuildPrimitive& p = primitives_[i];
      Bin& bin = bins[static_cast<std::size_t>(binOf(p))];
      const Float4 l = Float4::load(p.low), h = Float4::load(p.high);
      bin.box.grow(l, h);
      const Float4 centre = l + h;
      bin.centres.grow(centre, centre);
      ++bin.count;
    }
    const int at = bestSplit(bins, binCount);
    if (at < 0) return splitAtMedian(whole, axis, left, right);

    left = right = Range{};
    for (int i = 0; i < binCount; ++i) {
      Range& side = i < at ? left : right;
      side.box.grow(bins[static_cast<std::size_t>(i)].box);
      side.centres.grow(bins[static_cast<std::size_t>(i)].centres);
    }
    const auto middle = std::partition(primitives_.begin() + whole.begin, primitives_.begin() + whole.end,
                                       [&](const BuildPrimitive& p) { return binOf(p) < at; });
    finish(whole, static_cast<std::uint32_t>(middle - primitives_.begin()), left, right);
  }

  /// The first bin of the right side with the least surface-area cost, or -1 if one side would be empty.
  static int bestSplit(const std::array<Bin, kMaxBins>& bins, int binCount) {
    std::array<float, kMaxBins> rightCost{};
    Box4 box;
    std::uint32_t count = 0;
    for (int i = binCount - 1; i > 0; --i) {
      const Bin& bin = bins[static_cast<std::size_t>(i)];
      if (bin.count > 0) box.grow(bin.box);
      count += bin.count;
      rightCost[static_cast<std::size_t>(i)] = count > 0 ? halfArea(box) * static_cast<float>(count) : -1.0f;
    }
    int best = -1;
    float bestCost = kInfinity;
    box = Box4{};
    count = 0;
    for (int i = 1; i < binCount; ++i) {
      const Bin& bin = bins[static_cast<std::size_t>(i - 1)];
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
    const auto key = [axis](const BuildPrimitive& p) { return p.low[axis] + p.high[axis]; };
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

  std::vector<BuildPrimitive>& primitives_;
};

/// A subtree as one piece of work. Large ones become a node with four more; small ones are built whole.
struct Task {
  Range range;
  Node node;
  std::array<std::unique_ptr<Task>, 4> children;
  std::vector<Node> nodes;  // of a subtree built whole
};

class TaskPool {
 public:
  TaskPool(const Builder& builder, Task* root) : builder_(builder), open_(1) { queue_.push_back(root); }

  void run(int threads) {
    std::vector<std::thread> helpers;
    for (int i = 1; i < threads; ++i) helpers.emplace_back([this] { work(); });
    work();
    for (std::thread& helper : helpers) helper.join();
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

/// Lays the tasks' nodes out depth first: an order that does not depend on who built what, when.
std::uint32_t flatten(const Task& task, std::vector<Node>& nodes) {
  const std::uint32_t index = static_cast<std::uint32_t>(nodes.size());
  if (!task.nodes.empty()) {
    for (Node node : task.nodes) {
      for (std::uint32_t& child : node.child) {
        if ((child & TriangleBvh::kLeafBit) == 0) child += index;
      }
      nodes.push_back(node);
    }
    return index;
  }
  nodes.push_back(task.node);
  for (int i = 0; i < 4; ++i) {
    if (!task.children[i]) continue;
    const std::uint32_t child = flatten(*task.children[i], nodes);
    nodes[index].child[i] = child;
  }
  return index;
}

}  // namespace

std::vector<Node> buildNodes(std::vector<BuildPrimitive>& primitives, int threads) {
  Task root;
  root.range.end = static_cast<std::uint32_t>(primitives.size());
  for (const BuildPrimitive& p : primitives) grow(root.range, p);
  const Builder builder(primitives);
  TaskPool(builder, &root).run(threads);
  std::vector<Node> nodes;
  nodes.reserve(primitives.size() / 5 + 1);
  flatten(root, nodes);
  return nodes;
}

}  // namespace tandem::haptics
