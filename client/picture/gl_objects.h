#pragma once

// Owners of OpenGL names, and of programs made of them. Every call needs the context that made them to be
// current.

#include <epoxy/gl.h>

#include <cstddef>
#include <string>
#include <utility>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "assets/base/result.h"

namespace tandem::client {

enum class GlKind { buffer, vertexArray, framebuffer, renderbuffer, texture };

/// Owns one OpenGL name of a kind.
template <GlKind kind>
class GlName {
 public:
  GlName();
  ~GlName();
  GlName(GlName&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  GLuint id() const { return id_; }

 private:
  GLuint id_ = 0;
};

using GlBuffer = GlName<GlKind::buffer>;
using GlVertexArray = GlName<GlKind::vertexArray>;

/// A linked vertex and fragment shader with uniforms set by name.
class GlProgram {
 public:
  /// The error holds `name` and the compiler's log.
  static Result<GlProgram> make(const char* name, const std::string& vertex, const std::string& fragment);
  GlProgram(GlProgram&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlProgram& operator=(GlProgram&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~GlProgram();

  void use() const;
  void set(const char* uniform, float value) const;
  void set(const char* uniform, int value) const;
  void set(const char* uniform, const glm::vec2& value) const;
  void set(const char* uniform, const glm::vec3& value) const;
  void set(const char* uniform, const glm::vec4& value) const;
  void set(const char* uniform, const glm::mat4& value) const;

 private:
  explicit GlProgram(GLuint id) : id_(id) {}
  GLint location(const char* uniform) const;
  GLuint id_ = 0;
};

/// A colour, depth and stencil target; with samples > 0 it is multisampled and must be resolved before it is
/// read.
class GlTarget {
 public:
  /// Makes or remakes the target; nothing happens if it is that size already.
  void resize(const glm::ivec2& size, int samples, GLenum colourFormat);
  void bind() const;
  GLuint framebuffer() const { return framebuffer_.id(); }
  glm::ivec2 size() const { return size_; }

 private:
  GlName<GlKind::framebuffer> framebuffer_;
  GlName<GlKind::renderbuffer> colour_, depth_;
  glm::ivec2 size_{0, 0};
};

/// Vertex attribute `index` of the bound array, floats out of the bound buffer; divisor 1 = one an instance.
void floatAttribute(GLuint index, int components, std::size_t stride, std::size_t offset, int divisor = 0);

}  // namespace tandem::client
