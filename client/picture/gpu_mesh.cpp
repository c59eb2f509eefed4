#include "client/picture/gpu_mesh.h"

namespace tandem::client {

GpuMesh upload(const RenderMesh& mesh) {
  GpuMesh gpu;
  gpu.ranges = mesh.ranges;
  gpu.clusters = mesh.clusters;
  gpu.edgeCount = static_cast<int>(mesh.featureEdges.size() / 2);
  gpu.bytes = mesh.vertices.size() * sizeof(RenderVertex) + mesh.indices.size() * sizeof(std::uint32_t) +
              mesh.featureEdges.size() * sizeof(glm::vec3);
  glBindVertexArray(gpu.surface.id());
  fill(gpu.vertices, GL_ARRAY_BUFFER, mesh.vertices);
  fill(gpu.indices, GL_ELEMENT_ARRAY_BUFFER, mesh.indices);
  floatAttribute(0, 3, sizeof(RenderVertex), offsetof(RenderVertex, position));
  floatAttribute(1, 3, sizeof(RenderVertex), offsetof(RenderVertex, normal));
  glBindVertexArray(gpu.thinEdges.id());
  fill(gpu.edges, GL_ARRAY_BUFFER, mesh.featureEdges);
  floatAttribute(0, 3, sizeof(glm::vec3), 0);
  glBindVertexArray(gpu.wideEdges.id());
  floatAttribute(0, 3, 2 * sizeof(glm::vec3), 0, 1);
  floatAttribute(1, 3, 2 * sizeof(glm::vec3), sizeof(glm::vec3), 1);
  glBindVertexArray(0);
  return gpu;
}

}  // namespace tandem::client
