#pragma once

// The buffers of one render mesh. Needs the context that made them to be current.

#include <vector>

#include "client/levels/render_mesh.h"
#include "client/picture/gl_objects.h"

namespace tandem::client {

struct GpuMesh {
  GlVertexArray surface, thinEdges, wideEdges;
  GlBuffer vertices, indices, edges;
  std::vector<RenderRange> ranges;
  std::vector<RenderCluster> clusters;
  int edgeCount = 0;
  bool facesOutward = false;  // known to: no back of a face is seen from outside
  std::size_t bytes = 0;      // of the buffers
};

GpuMesh upload(const RenderMesh& mesh);

template <typename T>
void fill(const GlBuffer& buffer, GLenum target, const std::vector<T>& data, GLenum usage = GL_STATIC_DRAW) {
  glBindBuffer(target, buffer.id());
  glBufferData(target, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), usage);
}

}  // namespace tandem::client
