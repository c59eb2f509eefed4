#include "client/session/said_parts.h"

#include <optional>

#include "sync/wire/limits.h"

namespace tandem::client {

namespace {

struct Brackets {
  std::size_t open = 0, close = 0;
};

/// The next name in brackets at or after `from`; nothing if there is none.
std::optional<Brackets> nextName(const std::string& text, std::size_t from) {
  const std::size_t close = text.find(']', text.find('[', from));
  if (close == std::string::npos) return std::nullopt;
  const std::size_t open = text.rfind('[', close);
  if (open == std::string::npos || open < from) return std::nullopt;
  return Brackets{open, close};
}

}  // namespace

sync::Say saidWithLinks(const std::string& text, const assets::Scene& scene) {
  sync::Say said;
  said.text = text;
  for (std::optional<Brackets> name = nextName(text, 0); name && said.parts.size() < sync::kMaxSaidParts;
       name = nextName(text, name->close + 1))
    said.parts.push_back(assets::findPart(scene, text.substr(name->open + 1, name->close - name->open - 1)));
  return said;
}

std::string inWords(const sync::Say& said) {
  std::string words;
  std::size_t done = 0, from = 0;
  for (const PartId part : said.parts) {
    const std::optional<Brackets> name = nextName(said.text, from);
    if (!name) break;
    from = name->close + 1;
    if (part == kNoPart) continue;
    words += said.text.substr(done, name->open - done);
    words += said.text.substr(name->open + 1, name->close - name->open - 1);
    done = from;
  }
  return words + said.text.substr(done);
}

std::vector<SaidPiece> piecesOf(const sync::Say& said, const assets::Scene& scene) {
  std::vector<SaidPiece> pieces;
  const auto plain = [&](std::size_t from, std::size_t to) {
    if (to > from) pieces.push_back({said.text.substr(from, to - from), kNoPart});
  };
  std::size_t done = 0, from = 0;
  for (const PartId part : said.parts) {
    const std::optional<Brackets> name = nextName(said.text, from);
    if (!name) break;
    from = name->close + 1;
    if (part >= scene.parts.size()) continue;
    plain(done, name->open);
    pieces.push_back({scene.parts[part].name, part});
    done = from;
  }
  plain(done, said.text.size());
  return pieces;
}

}  // namespace tandem::client
