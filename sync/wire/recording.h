#pragma once

// A recording of a session: its messages with their session times, enough to replay it with its forces. One
// file, appended to while the session runs; a file cut off by a crash is readable up to the cut, a
// damaged one before and after the damage. No recording is ever written over.
//
// Layout: header (magic "TNDMREC1", scene hash, position range, checksum), then records (length, kind,
// session time, payload, checksum); sync/WIRE.md has the bytes. Payloads are control and state messages as on
// the wire, so recording and network have one codec.

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "assets/base/result.h"
#include "sync/wire/time.h"
#include "sync/wire/wire.h"

namespace tandem::sync {

struct RecordingHeader {
  std::array<std::uint8_t, 32> sceneHash{};
  WireFrame frame;
};

struct RecordingEntry {
  Micros time = 0;
  std::variant<ControlMessage, StateMessage> message;  // as the server relayed it, or as a site saw it
};

class RecordingWriter {
 public:
  /// Where a file that is not empty has this name, the recording gets the next free one: session-2.tandem,
  /// session-3.tandem and so on for session.tandem.
  static Result<RecordingWriter> create(const std::string& path, const RecordingHeader& header);
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;
  ~RecordingWriter();  // flushes

  /// The next flush() returns the error of a failed write; later entries are dropped.
  void write(Micros time, const ControlMessage& message);
  void write(Micros time, const StateMessage& message);
  Status flush();
  /// The name that the file got.
  const std::string& path() const;

 private:
  struct State;
  explicit RecordingWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

class RecordingReader {
 public:
  static Result<RecordingReader> open(const std::string& path);
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;
  ~RecordingReader();

  const RecordingHeader& header() const;
  /// The next intact entry; nothing at the end. What is damaged is passed over (see damaged()).
  std::optional<RecordingEntry> next();
  /// What was wrong at the first place that was passed over, and how much was passed over in all, in one
  /// line; empty if nothing was.
  std::string damaged() const;

 private:
  struct State;
  explicit RecordingReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tandem::sync
