#pragma once

// The viewer's GLSL 3.30 sources. Lighting is in eye space; colours are linear until the last line.

namespace tandem::client::shaders {

/// Put after the version of a vertex shader by programs that draw cut parts: a vertex is kept by a plane (eye
/// space: unit normal, offset) while its distance is not negative.
inline constexpr const char* kSections = R"(
uniform vec4 sections[8];
out float gl_ClipDistance[8];
void clip(vec3 eye) { for (int i = 0; i < 8; ++i) gl_ClipDistance[i] = dot(sections[i], vec4(eye, 1.0)); }
)";
/// In place of kSections where nothing is cut.
inline constexpr const char* kNoSections = "void clip(vec3 eye) {}\n";

/// Shared by everything that is lit: a key light over the person's right shoulder, a weak fill, and a
/// hemisphere of sky and floor. The highlight is Cook-Torrance with the GGX distribution (Walter et al. 2007)
/// and Schlick's Fresnel term.
inline constexpr const char* kLighting = R"(
uniform vec3 upInEye;
vec3 encode(vec3 c) { return pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2)); }
vec3 shade(vec3 base, float metallic, float roughness, vec3 n, vec3 v) {
  vec3 key = normalize(vec3(0.38, 0.62, 0.72));
  vec3 fill = normalize(vec3(-0.75, 0.05, 0.55));
  float nk = max(dot(n, key), 0.0), nv = max(dot(n, v), 1e-3);
  vec3 h = normalize(key + v);
  float nh = max(dot(n, h), 0.0);
  float a = max(roughness * roughness, 0.03);
  float a2 = a * a;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float distribution = a2 / (3.14159265 * d * d);
  float k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
  float visibility = 0.25 / ((nk * (1.0 - k) + k) * (nv * (1.0 - k) + k));
  vec3 f0 = mix(vec3(0.04), base, metallic);
  vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(h, v), 0.0), 5.0);
  vec3 diffuse = base * (1.0 - metallic);
  vec3 floorLight = vec3(0.25, 0.245, 0.24), skyLight = vec3(0.46, 0.48, 0.51);
  vec3 light = diffuse * mix(floorLight, skyLight, 0.5 + 0.5 * dot(n, upInEye));
  // What a surface mirrors: a bright sky over a dark floor, their border the softer the rougher the surface.
  float up = dot(reflect(-v, n), upInEye);
  float border = 0.15 + 0.85 * roughness;
  vec3 mirrored = mix(vec3(0.29, 0.29, 0.30), vec3(0.95, 0.97, 1.0), smoothstep(-border, border, up));
  vec3 grazing = f0 + (max(vec3(1.0 - roughness), f0) - f0) * pow(1.0 - nv, 5.0);
  light += mirrored * grazing * (1.0 - 0.35 * roughness);
  light += diffuse * (0.56 * nk + 0.14 * max(dot(n, fill), 0.0));
  light += 0.9 * nk * min(distribution * visibility, 4.0) * fresnel;
  return light;
}
)";

inline constexpr const char* kPartVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 eyeFromPart, clipFromEye;
out vec3 eyePosition, eyeNormal;
void main() {
  vec4 p = eyeFromPart * vec4(position, 1.0);
  eyePosition = p.xyz;
  eyeNormal = mat3(eyeFromPart) * normal;
  clip(p.xyz);
  gl_Position = clipFromEye * p;
}
)";

inline constexpr const char* kPartFragment = R"(
in vec3 eyePosition, eyeNormal;
uniform vec4 baseColour;
uniform vec3 tint;
uniform float tintAmount, rimAmount, metallic, roughness;
out vec4 colour;
void main() {
  vec3 v = normalize(-eyePosition);
  vec3 n = normalize(eyeNormal);
  if (dot(n, v) < 0.0) n = -n;
  vec3 base = mix(baseColour.rgb, tint, tintAmount);
  vec3 light = shade(base, metallic * (1.0 - tintAmount), roughness, n, v);
  float rim = pow(1.0 - max(dot(n, v), 0.0), 2.5);
  colour = vec4(encode(mix(light, tint, rimAmount * rim)), baseColour.a);
}
)";

/// A segment between two end points, drawn as a quad `width` pixels wide and pulled a little towards the eye.
inline constexpr const char* kLineVertex = R"(
layout(location = 0) in vec3 start;
layout(location = 1) in vec3 end;
uniform mat4 eyeFromPart, clipFromEye;
uniform vec2 viewport;
uniform float width, pull, nearPlane;
void main() {
  vec3 a = (eyeFromPart * vec4(start, 1.0)).xyz, b = (eyeFromPart * vec4(end, 1.0)).xyz;
  float limit = -nearPlane * 1.001;
  if (a.z > limit && b.z > limit) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (a.z > limit) a = mix(a, b, (limit - a.z) / (b.z - a.z));
  if (b.z > limit) b = mix(b, a, (limit - b.z) / (a.z - b.z));
  vec4 ca = clipFromEye * vec4(a * (1.0 - pull), 1.0), cb = clipFromEye * vec4(b * (1.0 - pull), 1.0);
  vec2 along = (cb.xy / cb.w - ca.xy / ca.w) * viewport;
  float len = length(along);
  along = len > 1e-6 ? along / len : vec2(1.0, 0.0);
  vec2 side = vec2(-along.y, along.x);
  vec4 p = (gl_VertexID & 1) == 0 ? ca : cb;
  float s = (gl_VertexID & 2) == 0 ? 1.0 : -1.0;
  p.xy += side * s * width / viewport * p.w;
  clip((gl_VertexID & 1) == 0 ? a : b);
  gl_Position = p;
}
)";

/// The same segments as plain GL lines, for the many edges of parts that nothing marks.
inline constexpr const char* kThinLineVertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 eyeFromPart, clipFromEye;
uniform float pull;
void main() {
  vec3 p = (eyeFromPart * vec4(position, 1.0)).xyz;
  clip(p);
  gl_Position = clipFromEye * vec4(p * (1.0 - pull), 1.0);
}
)";

inline constexpr const char* kFlatFragment = R"(#version 330 core
uniform vec4 flatColour;
out vec4 colour;
void main() { colour = flatColour; }
)";

inline constexpr const char* kBackgroundVertex = R"(#version 330 core
out float height;
void main() {
  vec2 p = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
  height = 0.5 + 0.5 * p.y;
  gl_Position = vec4(p, 0.9999, 1.0);
}
)";
inline constexpr const char* kBackgroundFragment = R"(#version 330 core
in float height;
uniform vec3 top, bottom;
out vec4 colour;
void main() { colour = vec4(mix(bottom, top, smoothstep(0.0, 1.0, height)), 1.0); }
)";

inline constexpr const char* kPickFragment = R"(#version 330 core
uniform float partIndex;
out vec4 colour;
void main() { colour = vec4(mod(partIndex, 256.0), floor(partIndex / 256.0), 0.0, 255.0) / 255.0; }
)";

/// Small solids of hands, arrows and contacts: already in eye space, with a colour a vertex.
inline constexpr const char* kGlyphVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 vertexColour;
uniform mat4 clipFromEye;
out vec3 eyePosition, eyeNormal;
out vec4 glyphColour;
void main() {
  eyePosition = position;
  eyeNormal = normal;
  glyphColour = vertexColour;
  gl_Position = clipFromEye * vec4(position, 1.0);
}
)";
inline constexpr const char* kGlyphFragment = R"(
in vec3 eyePosition, eyeNormal;
in vec4 glyphColour;
uniform float opacity;
out vec4 colour;
void main() {
  vec3 v = normalize(-eyePosition);
  vec3 n = normalize(eyeNormal);
  if (dot(n, v) < 0.0) n = -n;
  colour = vec4(encode(shade(glyphColour.rgb, 0.0, 0.45, n, v)), glyphColour.a * opacity);
}
)";

}  // namespace tandem::client::shaders
