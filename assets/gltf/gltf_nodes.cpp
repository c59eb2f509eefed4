#include "assets/gltf/gltf_nodes.h"

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "assets/scene/scene.h"

namespace tandem::assets {
namespace {

bool isFinite(const glm::dmat4& m) {
  double sum = 0.0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) sum += m[c][r] * 0.0;
  return sum == 0.0;
}

glm::dmat4 localTransform(const GltfNode& node, const std::string& place) {
  glm::dmat4 local(1.0);
  if (node.matrix.size() == 16) {
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) local[c][r] = node.matrix[static_cast<std::size_t>(c * 4 + r)];
    if (local[0][3] != 0.0 || local[1][3] != 0.0 || local[2][3] != 0.0 || local[3][3] != 1.0)
      throw GltfError(place + ".matrix", "is not an affine transform");
  } else {
    const auto& t = node.translation;
    const auto& q = node.rotation;
    const auto& s = node.scale;
    if (t.size() == 3) local = glm::translate(local, glm::dvec3(t[0], t[1], t[2]));
    if (q.size() == 4) {
      const glm::dquat rotation(q[3], q[0], q[1], q[2]);
      const double length = glm::length(rotation);
      if (!(length > 1e-9 && length < 1e9)) throw GltfError(place + ".rotation", "is not a rotation");
      local *= glm::mat4_cast(rotation / length);
    }
    if (s.size() == 3) local = glm::scale(local, glm::dvec3(s[0], s[1], s[2]));
  }
  if (!isFinite(local)) throw GltfError(place, "the transform is not finite");
  return local;
}

/// How often each node is a child; refuses nodes with two parents.
std::vector<bool> findChildren(const GltfModel& model) {
  std::vector<bool> isChild(model.nodes.size(), false);
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    for (const int child : model.nodes[i].children) {
      const auto c = static_cast<std::size_t>(child);
      if (isChild[c])
        throw GltfError(placeName("nodes", i, "children"),
                        "node " + std::to_string(child) + " has a second parent");
      isChild[c] = true;
    }
  return isChild;
}

/// Since a node has at most one parent, every node that no root reaches lies on or below a cycle.
void refuseCycles(const GltfModel& model, const std::vector<bool>& isChild) {
  std::vector<std::size_t> stack;
  std::vector<bool> visited(model.nodes.size(), false);
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    if (!isChild[i]) stack.push_back(i);
  while (!stack.empty()) {
    const std::size_t node = stack.back();
    stack.pop_back();
    visited[node] = true;
    for (const int child : model.nodes[node].children) stack.push_back(static_cast<std::size_t>(child));
  }
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    if (!visited[i]) throw GltfError(placeName("nodes", i), "belongs to a cycle of nodes");
}

std::vector<std::size_t> sceneRoots(const GltfDocument& document, const std::vector<bool>& isChild) {
  const GltfModel& model = document.model;
  std::vector<std::size_t> roots;
  if (model.scenes.empty()) {
    for (std::size_t i = 0; i < model.nodes.size(); ++i)
      if (!isChild[i]) roots.push_back(i);
    return roots;
  }
  const auto scene = static_cast<std::size_t>(std::max(0, model.defaultScene));
  std::vector<bool> listed(model.nodes.size(), false);
  for (const int root : model.scenes[scene]) {
    const auto r = static_cast<std::size_t>(root);
    const std::string place = placeName("scenes", scene, "nodes");
    if (isChild[r]) throw GltfError(place, "node " + std::to_string(root) + " is not a root");
    if (listed[r]) throw GltfError(place, "node " + std::to_string(root) + " is listed twice");
    listed[r] = true;
    roots.push_back(r);
  }
  return roots;
}

}  // namespace

std::vector<FlatNode> flattenNodes(const GltfDocument& document, double unitScale) {
  const GltfModel& model = document.model;
  const std::vector<bool> isChild = findChildren(model);
  refuseCycles(model, isChild);
  struct Pending {
    std::size_t node;
    std::uint32_t parent;
  };
  std::vector<Pending> stack;
  const std::vector<std::size_t> roots = sceneRoots(document, isChild);
  for (auto it = roots.rbegin(); it != roots.rend(); ++it) stack.push_back({*it, kNone});
  const glm::dmat4 world = glm::scale(glm::dmat4(1.0), glm::dvec3(unitScale));
  std::vector<FlatNode> flat;
  while (!stack.empty()) {
    const Pending next = stack.back();
    stack.pop_back();
    const std::string place = placeName("nodes", next.node);
    const glm::dmat4& above = next.parent == kNone ? world : flat[next.parent].worldFromNode;
    const glm::dmat4 worldFromNode = above * localTransform(model.nodes[next.node], place);
    if (!isFinite(worldFromNode)) throw GltfError(place, "the transform is not finite");
    const auto self = static_cast<std::uint32_t>(flat.size());
    flat.push_back({next.node, next.parent, worldFromNode});
    const std::vector<int>& children = model.nodes[next.node].children;
    for (auto it = children.rbegin(); it != children.rend(); ++it)
      stack.push_back({static_cast<std::size_t>(*it), self});
  }
  return flat;
}

std::vector<SubtreeMesh> subtreeMeshes(const GltfDocument& document, std::size_t root, std::size_t& budget) {
  std::vector<SubtreeMesh> out;
  std::vector<SubtreeMesh> stack{{root, glm::dmat4(1.0)}};
  while (!stack.empty()) {
    const SubtreeMesh next = stack.back();
    stack.pop_back();
    if (budget-- == 0)
      throw GltfError(placeName("nodes", root), "too many colliders are made of other nodes");
    const GltfNode& node = document.model.nodes[next.gltfNode];
    if (node.mesh >= 0) out.push_back(next);
    for (auto it = node.children.rbegin(); it != node.children.rend(); ++it) {
      const auto child = static_cast<std::size_t>(*it);
      stack.push_back({child, next.rootFromNode *
                                  localTransform(document.model.nodes[child], placeName("nodes", child))});
    }
  }
  return out;
}

}  // namespace tandem::assets
