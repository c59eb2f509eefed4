#include "assets/mesh/edge_pairs.h"

#include <algorithm>

namespace tandem::assets {
namespace {

/// Entries with a key of two vertices, in one bucket per first vertex by a counting sort.
struct Bucketed {
  std::uint32_t second = 0;
  std::uint32_t third = 0;
  std::uint32_t index = 0;

  bool operator<(const Bucketed& other) const {
    if (second != other.second) return second < other.second;
    return third != other.third ? third < other.third : index < other.index;
  }
};

struct VertexBuckets {
  std::vector<std::uint32_t> begin;  // V + 1
  std::vector<Bucketed> entries;
};

/// Sorts the entries of each bucket. Most hold a handful; only the tip of a large fan needs the general sort.
void sortBuckets(VertexBuckets& buckets) {
  for (std::size_t v = 0; v + 1 < buckets.begin.size(); ++v) {
    const auto first = buckets.entries.begin() + buckets.begin[v];
    const auto last = buckets.entries.begin() + buckets.begin[v + 1];
    if (last - first > 24) {
      std::sort(first, last);
      continue;
    }
    for (auto i = first; i != last; ++i) {
      const Bucketed entry = *i;
      auto hole = i;
      for (; hole != first && entry < *(hole - 1); --hole) *hole = *(hole - 1);
      *hole = entry;
    }
  }
}

/// Turns counts at v + 1 into the places where buckets begin.
void accumulate(std::vector<std::uint32_t>& begin) {
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
}

/// The triangles, bucketed by lowest corner.
VertexBuckets bucketTriangles(const std::vector<TriangleIndices>& triangles, std::size_t vertexCount) {
  VertexBuckets buckets{std::vector<std::uint32_t>(vertexCount + 1), std::vector<Bucketed>(triangles.size())};
  for (const TriangleIndices& t : triangles) ++buckets.begin[std::min({t[0], t[1], t[2]}) + 1];
  accumulate(buckets.begin);
  std::vector<std::uint32_t> next(buckets.begin.begin(), buckets.begin.end() - 1);
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    TriangleIndices t = triangles[i];
    std::sort(t.begin(), t.end());
    buckets.entries[next[t[0]]++] = {t[1], t[2], i};
  }
  sortBuckets(buckets);
  return buckets;
}

/// The halfedges, bucketed by lower vertex.
VertexBuckets bucketEdges(const std::vector<TriangleIndices>& triangles, std::size_t vertexCount) {
  VertexBuckets buckets{std::vector<std::uint32_t>(vertexCount + 1),
                        std::vector<Bucketed>(3 * triangles.size())};
  for (const TriangleIndices& t : triangles)
    for (int e = 0; e < 3; ++e) ++buckets.begin[std::min(t[e], t[(e + 1) % 3]) + 1];
  accumulate(buckets.begin);
  std::vector<std::uint32_t> next(buckets.begin.begin(), buckets.begin.end() - 1);
  for (std::uint32_t h = 0; h < 3 * triangles.size(); ++h) {
    const auto [low, high] = std::minmax({startOf(triangles, h), endOf(triangles, h)});
    buckets.entries[next[low]++] = {high, 0, h};
  }
  sortBuckets(buckets);
  return buckets;
}

}  // namespace

std::uint64_t dropDuplicates(std::vector<TriangleIndices>& triangles, std::vector<std::uint16_t>& material,
                             std::size_t vertexCount) {
  const VertexBuckets buckets = bucketTriangles(triangles, vertexCount);
  std::vector<bool> drop(triangles.size());
  std::uint64_t dropped = 0;
  for (std::size_t v = 0; v < vertexCount; ++v) {
    for (std::uint32_t i = buckets.begin[v] + 1; i < buckets.begin[v + 1]; ++i) {
      const Bucketed &a = buckets.entries[i - 1], &b = buckets.entries[i];
      if (a.second != b.second || a.third != b.third) continue;
      drop[b.index] = true;
      ++dropped;
    }
  }
  if (dropped == 0) return 0;
  std::size_t count = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (drop[t]) continue;
    triangles[count] = triangles[t];
    material[count++] = material[t];
  }
  triangles.resize(count);
  material.resize(count);
  return dropped;
}

EdgePairs pairEdges(const std::vector<TriangleIndices>& triangles, std::size_t vertexCount) {
  EdgePairs pairs;
  pairs.across.assign(3 * triangles.size(), kOpenEdge);
  const VertexBuckets buckets = bucketEdges(triangles, vertexCount);
  const std::vector<Bucketed>& entries = buckets.entries;
  for (std::size_t v = 0; v < vertexCount; ++v) {
    for (std::uint32_t first = buckets.begin[v], last = first; first < buckets.begin[v + 1]; first = last) {
      while (last < buckets.begin[v + 1] && entries[last].second == entries[first].second) ++last;
      if (last - first == 1) {
        ++pairs.openEdges;
      } else if (last - first == 2) {
        pairs.across[entries[first].index] = entries[first + 1].index;
        pairs.across[entries[first + 1].index] = entries[first].index;
      } else {
        std::vector<std::uint32_t>& edge = pairs.manyFaced.emplace_back();
        for (std::uint32_t i = first; i < last; ++i) {
          edge.push_back(entries[i].index);
          pairs.across[entries[i].index] = kManyFacedEdge;
        }
      }
    }
  }
  return pairs;
}

namespace {

enum class Turn : std::uint8_t { unseen, keep, flip };

Turn opposite(Turn turn) { return turn == Turn::keep ? Turn::flip : Turn::keep; }

/// Visits the shell of `seed` and decides for each face whether it must be reversed to agree with the seed.
/// Appends the faces to `shell`; returns whether the shell is orientable.
bool walkShell(const std::vector<TriangleIndices>& triangles, const EdgePairs& pairs, std::uint32_t seed,
               std::vector<Turn>& turns, std::vector<std::uint32_t>& shell) {
  bool orientable = true;
  turns[seed] = Turn::keep;
  shell.assign(1, seed);
  for (std::size_t i = 0; i < shell.size(); ++i) {
    for (std::uint32_t h = 3 * shell[i]; h < 3 * shell[i] + 3; ++h) {
      const std::uint32_t other = pairs.across[h];
      if (other >= kManyFacedEdge) continue;
      const bool agree = startOf(triangles, h) != startOf(triangles, other);
      const Turn wanted = agree ? turns[shell[i]] : opposite(turns[shell[i]]);
      Turn& turn = turns[other / 3];
      if (turn == Turn::unseen) {
        turn = wanted;
        shell.push_back(other / 3);
      } else if (turn != wanted) {
        orientable = false;
      }
    }
  }
  return orientable;
}

/// Reverses the marked triangles and renames their halfedges.
void flipMarked(std::vector<TriangleIndices>& triangles, EdgePairs& pairs, const std::vector<Turn>& turns) {
  const auto renamed = [&turns](std::uint32_t h) {
    return turns[h / 3] == Turn::flip ? h - h % 3 + reversedEdge(h % 3) : h;
  };
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (turns[t] == Turn::flip) {
      triangles[t] = reversed(triangles[t]);
      std::swap(pairs.across[3 * t], pairs.across[3 * t + 2]);
    }
  }
  for (std::uint32_t& other : pairs.across)
    if (other < kManyFacedEdge) other = renamed(other);
  for (std::vector<std::uint32_t>& edge : pairs.manyFaced)
    for (std::uint32_t& h : edge) h = renamed(h);
}

}  // namespace

Orientation orientAlike(std::vector<TriangleIndices>& triangles, EdgePairs& pairs) {
  Orientation result;
  std::vector<Turn> turns(triangles.size(), Turn::unseen);
  std::vector<std::uint32_t> shell;
  for (std::uint32_t seed = 0; seed < triangles.size(); ++seed) {
    if (turns[seed] != Turn::unseen) continue;
    if (!walkShell(triangles, pairs, seed, turns, shell)) ++result.nonOrientableShells;
    std::size_t flips = 0;
    for (const std::uint32_t t : shell) flips += turns[t] == Turn::flip ? 1 : 0;
    if (2 * flips > shell.size()) {
      for (const std::uint32_t t : shell) turns[t] = opposite(turns[t]);
      flips = shell.size() - flips;
    }
    result.flippedFaces += flips;
  }
  if (result.flippedFaces > 0) flipMarked(triangles, pairs, turns);
  return result;
}

}  // namespace tandem::assets
