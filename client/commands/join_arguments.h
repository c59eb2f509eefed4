#pragma once

// What `tandem join` is told on its command line.

#include <string>
#include <vector>

#include "client/commands/command.h"
#include "client/marks/section_set.h"
#include "client/session/connection_options.h"

namespace tandem::client {

struct JoinArguments {
  std::string link, device, calibration, hand, secondDevice, secondCalibration, secondHand, screenshot,
      record, json, trace, name, colour, cache, tool;
  bool headless = false, tcp = false, quiet = false, noPartContact = false, facets = false, notes = false,
       measures = false, alone = false;
  double duration = 0.0, clashes = -1.0;            // s; m, negative: the list of clashes stays closed
  int width = 1440, height = 900, maxScene = 2048;  // pixels; MiB
  std::vector<std::string> sections;
  SectionSet cut;  // what `sections` say
  document::PartStyle style;
  std::string colourBy, wayOut;
  double deadband = PublishRates{}.deadband;
};

void addJoinOptions(assets::CommandLine& command, JoinArguments& arguments);
/// Takes --colour-by as a name.
Status setColouring(JoinArguments& arguments);

}  // namespace tandem::client
