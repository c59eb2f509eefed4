#include "sync/transport/join_link.h"
#include "sync/wire/limits.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace tandem::sync {
namespace {

constexpr const char* kScheme = "tandem://";
constexpr char kHex[] = "0123456789abcdef";

bool isUnreserved(char c) {  // RFC 3986 section 2.3
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ||
         c == '_' || c == '~';
}

std::string percentEncode(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (isUnreserved(c)) {
      out += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      out += {'%', kHex[byte >> 4], kHex[byte & 15]};
    }
  }
  return out;
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Decoded to printable ASCII, or nothing.
std::optional<std::string> percentDecode(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size() || hexDigit(text[i + 1]) < 0 || hexDigit(text[i + 2]) < 0) return std::nullopt;
      c = static_cast<char>(hexDigit(text[i + 1]) * 16 + hexDigit(text[i + 2]));
      i += 2;
    }
    if (c <= 0x20 || c >= 0x7f) return std::nullopt;
    out += c;
  }
  return out;
}

/// Splits HOST:PORT or [IPV6]:PORT.
Status parseAuthority(const std::string& text, JoinLink& link) {
  const bool bracketed = !text.empty() && text[0] == '[';
  const std::size_t hostEnd = bracketed ? text.find(']') : text.rfind(':');
  const std::size_t colon = bracketed && hostEnd != std::string::npos ? hostEnd + 1 : hostEnd;
  if (hostEnd == std::string::npos || colon >= text.size() || text[colon] != ':') {
    return Error{"join link: there is no port after the host"};
  }
  link.host = bracketed ? text.substr(1, hostEnd - 1) : text.substr(0, hostEnd);
  const bool tooManyColons = !bracketed && link.host.find(':') != std::string::npos;
  if (link.host.empty() || link.host.size() > 253 || tooManyColons)
    return Error{"join link: the host is not valid"};
  for (const char c : link.host) {
    if (!isUnreserved(c) && c != ':') return Error{"join link: the host is not valid"};
  }
  const char* first = text.data() + colon + 1;
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(first, last, link.port);
  if (error != std::errc{} || end != last || link.port == 0)
    return Error{"join link: the port is not 1 to 65535"};
  return {};
}

Status parseParameter(const std::string& parameter, JoinLink& link) {
  const std::size_t equals = parameter.find('=');
  const std::string name = parameter.substr(0, equals);
  const auto value = percentDecode(equals == std::string::npos ? "" : parameter.substr(equals + 1));
  if (name != "token" && name != "pin") return {};  // a later version may add parameters
  std::string& field = name == "token" ? link.token : link.pin;
  if (!field.empty()) return Error{"join link: " + name + " is given twice"};
  if (!value || value->empty()) return Error{"join link: " + name + " is empty or not printable"};
  field = *value;
  return {};
}

}  // namespace

std::string toString(const JoinLink& link) {
  const bool ipv6 = link.host.find(':') != std::string::npos;
  return kScheme + (ipv6 ? "[" + link.host + "]" : link.host) + ":" + std::to_string(link.port) + "/" +
         toString(link.role) + "?token=" + percentEncode(link.token) + "&pin=" + link.pin;
}

Result<JoinLink> parseJoinLink(const std::string& text) {
  const std::string scheme = kScheme;
  if (text.size() > 4096) return Error{"join link: too long"};
  if (text.compare(0, scheme.size(), scheme) != 0) return Error{"join link: does not start with tandem://"};
  const std::size_t slash = text.find('/', scheme.size());
  const std::size_t question = text.find('?', scheme.size());
  if (slash == std::string::npos || question == std::string::npos || question < slash) {
    return Error{"join link: not of the form tandem://HOST:PORT/ROLE?token=TOKEN&pin=PIN"};
  }
  JoinLink link;
  if (Status s = parseAuthority(text.substr(scheme.size(), slash - scheme.size()), link); !s)
    return s.error();

  const std::string role = text.substr(slash + 1, question - slash - 1);
  bool known = false;
  for (const Role r : {Role::observer, Role::participant, Role::instructor}) {
    if (role == toString(r)) {
      link.role = r;
      known = true;
    }
  }
  if (!known) return Error{"join link: the role is not observer, participant or instructor"};

  for (std::size_t start = question + 1; start <= text.size();) {
    const std::size_t end = std::min(text.find('&', start), text.size());
    if (Status s = parseParameter(text.substr(start, end - start), link); !s) return s.error();
    start = end + 1;
  }
  if (link.token.empty()) return Error{"join link: there is no token"};
  if (link.token.size() > kMaxCredentialLength) return Error{"join link: the token is too long"};
  if (link.pin.size() != 64) return Error{"join link: the pin is not 64 hexadecimal digits"};
  for (char& c : link.pin) {
    const int digit = hexDigit(c);
    if (digit < 0) return Error{"join link: the pin is not 64 hexadecimal digits"};
    c = kHex[digit];
  }
  return link;
}

}  // namespace tandem::sync
