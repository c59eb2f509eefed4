#include "client/picture/gl_objects.h"

#include <array>
#include <cstdint>

#include <glm/gtc/type_ptr.hpp>

#include "assets/base/assert.h"

namespace tandem::client {
namespace {

void generate(GlKind kind, GLuint* id) {
  switch (kind) {
    case GlKind::buffer:
      glGenBuffers(1, id);
      break;
    case GlKind::vertexArray:
      glGenVertexArrays(1, id);
      break;
    case GlKind::framebuffer:
      glGenFramebuffers(1, id);
      break;
    case GlKind::renderbuffer:
      glGenRenderbuffers(1, id);
      break;
    case GlKind::texture:
      glGenTextures(1, id);
      break;
  }
}

void destroy(GlKind kind, const GLuint* id) {
  switch (kind) {
    case GlKind::buffer:
      glDeleteBuffers(1, id);
      break;
    case GlKind::vertexArray:
      glDeleteVertexArrays(1, id);
      break;
    case GlKind::framebuffer:
      glDeleteFramebuffers(1, id);
      break;
    case GlKind::renderbuffer:
      glDeleteRenderbuffers(1, id);
      break;
    case GlKind::texture:
      glDeleteTextures(1, id);
      break;
  }
}

Result<GLuint> compile(const char* name, GLenum stage, const std::string& source) {
  const GLuint shader = glCreateShader(stage);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint ok = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::array<char, 1024> log{};
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  return Error{std::string("shader ") + name + " does not compile: " + log.data()};
}

}  // namespace

template <GlKind kind>
GlName<kind>::GlName() {
  generate(kind, &id_);
}
template <GlKind kind>
GlName<kind>::~GlName() {
  if (id_ != 0) destroy(kind, &id_);
}
template class GlName<GlKind::buffer>;
template class GlName<GlKind::vertexArray>;
template class GlName<GlKind::framebuffer>;
template class GlName<GlKind::renderbuffer>;
template class GlName<GlKind::texture>;

Result<GlProgram> GlProgram::make(const char* name, const std::string& vertex, const std::string& fragment) {
  auto vertexShader = compile(name, GL_VERTEX_SHADER, vertex);
  if (!vertexShader) return vertexShader.error();
  auto fragmentShader = compile(name, GL_FRAGMENT_SHADER, fragment);
  if (!fragmentShader) {
    glDeleteShader(*vertexShader);
    return fragmentShader.error();
  }
  const GLuint id = glCreateProgram();
  glAttachShader(id, *vertexShader);
  glAttachShader(id, *fragmentShader);
  glLinkProgram(id);
  glDeleteShader(*vertexShader);
  glDeleteShader(*fragmentShader);
  GlProgram program(id);
  GLint ok = GL_FALSE;
  glGetProgramiv(id, GL_LINK_STATUS, &ok);
  if (ok != GL_TRUE) return Error{std::string("shader ") + name + " does not link"};
  return program;
}

GlProgram::~GlProgram() {
  if (id_ != 0) glDeleteProgram(id_);
}

GLint GlProgram::location(const char* uniform) const { return glGetUniformLocation(id_, uniform); }
void GlProgram::use() const { glUseProgram(id_); }
void GlProgram::set(const char* uniform, float value) const { glUniform1f(location(uniform), value); }
void GlProgram::set(const char* uniform, int value) const { glUniform1i(location(uniform), value); }
void GlProgram::set(const char* uniform, const glm::vec2& value) const {
  glUniform2fv(location(uniform), 1, glm::value_ptr(value));
}
void GlProgram::set(const char* uniform, const glm::vec3& value) const {
  glUniform3fv(location(uniform), 1, glm::value_ptr(value));
}
void GlProgram::set(const char* uniform, const glm::vec4& value) const {
  glUniform4fv(location(uniform), 1, glm::value_ptr(value));
}
void GlProgram::set(const char* uniform, const glm::mat4& value) const {
  glUniformMatrix4fv(location(uniform), 1, GL_FALSE, glm::value_ptr(value));
}

void GlTarget::resize(const glm::ivec2& size, int samples, GLenum colourFormat) {
  ASSERT(size.x > 0 && size.y > 0 && samples >= 0);
  if (size == size_) return;
  size_ = size;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glBindRenderbuffer(GL_RENDERBUFFER, colour_.id());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, colourFormat, size.x, size.y);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_.id());
  glBindRenderbuffer(GL_RENDERBUFFER, depth_.id());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH24_STENCIL8, size.x, size.y);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
}

void GlTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glViewport(0, 0, size_.x, size_.y);
}

void floatAttribute(GLuint index, int components, std::size_t stride, std::size_t offset, int divisor) {
  ASSERT(components >= 1 && components <= 4 && offset < stride);
  glEnableVertexAttribArray(index);
  glVertexAttribPointer(index, components, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                        reinterpret_cast<const void*>(static_cast<std::uintptr_t>(offset)));
  glVertexAttribDivisor(index, static_cast<GLuint>(divisor));
}

}  // namespace tandem::client
