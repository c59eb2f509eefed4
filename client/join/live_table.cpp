#include "client/join/live_table.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/utc_time.h"
#include "client/base/readable.h"
#include "client/session/document_words.h"
#include "client/session/holding_words.h"
#include "client/session/said_parts.h"

namespace tandem::client {

namespace {

constexpr std::size_t kEarlierLines = 10;  // of what was said before, that are printed

std::string orDash(const std::string& text) { return text.empty() ? "-" : text; }

/// "block with ben: stiff (27 ms)".
std::string heldHere(const ViewModel& model) {
  const std::string shared = sharingInWords(model);
  return orDash(partName(model, model.hand.held)) + (shared.empty() ? "" : " " + shared);
}

/// A number, or a dash while it is not known.
std::string figure(bool known, const char* pattern, double value) {
  char text[32];
  std::snprintf(text, sizeof text, pattern, value);
  return known ? text : "-";
}

std::string faultLine(const ViewModel& model) {
  return "force is off: broken: " + model.hand.fault + "; kill -USR1 " + std::to_string(::getpid()) +
         " clears it";
}

}  // namespace

LiveTable::LiveTable(bool quiet) : quiet_(quiet), terminal_(isatty(STDOUT_FILENO) != 0) {}

void LiveTable::show(const ViewModel& model, double elapsed) {
  if (quiet_ || !model.scene) return;
  printEarlier(model);
  if (!terminal_) printNews(model, elapsed);
  if (elapsed < next_) return;
  next_ = elapsed + (terminal_ ? 0.2 : 2.0);
  if (!terminal_) {
    std::printf("%7.1f s  %s  %zu here  rtt %s ms  tick p99 %s us  force %.2f N  holds %s\n", elapsed,
                model.connection.status.c_str(), model.sites.size(),
                figure(model.connection.roundTrip_ms > 0.0, "%.1f", model.connection.roundTrip_ms).c_str(),
                figure(model.loop.ticks > 0, "%.0f", model.loop.compute_us_p99).c_str(),
                glm::length(model.hand.force), heldHere(model).c_str());
    printDocument(model, elapsed);
    std::fflush(stdout);
    return;
  }
  if (lines_ > 0) std::printf("\033[%dA", lines_);
  lines_ = 0;
  const auto end = [this] {
    std::fputs("\033[K\n", stdout);
    ++lines_;
  };
  const bool known = model.connection.roundTrip_ms > 0.0;
  std::printf("%6.1f s  %s  %s  rtt %s ms  loss %s/%s %%  play-out %s ms", elapsed,
              model.connection.status.c_str(), known ? model.connection.stateOverUdp ? "UDP" : "TLS" : "-",
              figure(known, "%.1f", model.connection.roundTrip_ms).c_str(),
              figure(known, "%.1f", 100.0 * model.connection.lossUp).c_str(),
              figure(known, "%.1f", 100.0 * model.connection.lossDown).c_str(),
              figure(known, "%.1f", model.connection.playOut_ms).c_str());
  end();
  std::printf("loop  %llu ticks  %.1f us p50  %.1f us p99  %llu late%s",
              static_cast<unsigned long long>(model.loop.ticks), model.loop.compute_us_p50,
              model.loop.compute_us_p99, static_cast<unsigned long long>(model.loop.late),
              model.loop.realtime ? "" : "  (not real-time)");
  if (model.loop.refined < 1.0) std::printf("  contact is refined: %.0f %%", 100.0 * model.loop.refined);
  end();
  std::printf("hand  %.2f N  touches %s  holds %s", glm::length(model.hand.force),
              orDash(partName(model, model.hand.touched)).c_str(), heldHere(model).c_str());
  end();
  if (!model.connection.voiceUrl.empty()) {
    std::printf("voice  %s", model.connection.voiceUrl.c_str());
    end();
  }
  if (model.document != nullptr) {
    std::fputs(("document  " + inWords(*model.document)).c_str(), stdout);
    end();
  }
  if (!model.hand.fault.empty()) {
    std::fputs(("  ! " + faultLine(model)).c_str(), stdout);
    end();
  }
  for (const SiteView& site : model.sites) {
    std::printf("  %s%-16s %-11s %-5s %s", site.self ? "*" : " ", site.info.name.c_str(),
                sync::toString(site.info.role), site.info.connected ? "here" : "away",
                holdingInWords(model, site).c_str());
    end();
  }
  for (const Notice& notice : model.notices) {
    std::printf("  ! %s", notice.text.c_str());
    end();
  }
  std::fputs("\033[J", stdout);
  std::fflush(stdout);
}

/// Prints the newest of the lines that were said before, once, above the table.
void LiveTable::printEarlier(const ViewModel& model) {
  std::vector<const ChatLine*> earlier;
  for (const ChatLine& chat : model.chat)
    if (chat.earlier && chat.number > printedChat_) earlier.push_back(&chat);
  if (earlier.empty()) return;
  printedChat_ = earlier.back()->number;
  if (lines_ > 0) std::printf("\033[%dA\033[J", lines_);
  lines_ = 0;
  const std::size_t left = earlier.size() - std::min(earlier.size(), kEarlierLines);
  if (left > 0) std::printf("(%zu lines were said before these)\n", left);
  for (std::size_t i = left; i < earlier.size(); ++i) {
    const sync::SaidLine& line = earlier[i]->line;
    std::printf("%s  %s said: %s\n", clockTime(line.at, systemUnixTime()).c_str(), line.name.c_str(),
                inWords(line.said).c_str());
  }
  std::fflush(stdout);
}

/// Prints each notice once, when it arrives.
void LiveTable::printNews(const ViewModel& model, double elapsed) {
  for (const Notice& notice : model.notices)
    if (notice.number > printed_) {
      printed_ = notice.number;
      std::printf("%7.1f s  %s\n", elapsed, notice.text.c_str());
      std::fflush(stdout);
    }
  if (model.hand.fault == printedFault_) return;
  printedFault_ = model.hand.fault;
  std::printf("%7.1f s  %s\n", elapsed,
              printedFault_.empty() ? "the fault is cleared" : faultLine(model).c_str());
  std::fflush(stdout);
}

/// Prints one line about the session's document whenever it has changed.
void LiveTable::printDocument(const ViewModel& model, double elapsed) {
  if (model.document == nullptr || model.document->revision() == printedRevision_) return;
  printedRevision_ = model.document->revision();
  std::printf("%7.1f s  document: %s\n", elapsed, inWords(*model.document).c_str());
}

void LiveTable::summary(const ViewModel& model, const std::string& end, std::size_t grabs,
                        std::size_t shared) {
  const bool known = model.connection.roundTrip_ms > 0.0;
  std::printf(
      "%s: %llu ticks, %.1f/%.1f us p50/p99, %llu late; rtt %s ms, loss %s/%s %%; %zu grab%s, %zu part%s "
      "shared with others\n",
      end.c_str(), static_cast<unsigned long long>(model.loop.ticks), model.loop.compute_us_p50,
      model.loop.compute_us_p99, static_cast<unsigned long long>(model.loop.late),
      figure(known, "%.2f", model.connection.roundTrip_ms).c_str(),
      figure(known, "%.1f", 100.0 * model.connection.lossUp).c_str(),
      figure(known, "%.1f", 100.0 * model.connection.lossDown).c_str(), grabs, grabs == 1 ? "" : "s", shared,
      shared == 1 ? "" : "s");
  if (model.document != nullptr) std::printf("document: %s\n", inWords(*model.document).c_str());
}

}  // namespace tandem::client
