#include "client/commands/join_arguments.h"

#include <optional>

namespace tandem::client {

Status setColouring(JoinArguments& arguments) {
  if (arguments.colourBy.empty()) return {};
  const std::optional<document::PartColouring> named = document::colouringNamed(arguments.colourBy);
  if (!named) return Error{"--colour-by " + arguments.colourBy + ": must be body, material or owner"};
  arguments.style.colouring = *named;
  return {};
}

namespace {

/// How the scene is cut open and its parts are drawn.
void addLooks(assets::CommandLine& command, JoinArguments& arguments) {
  command.option("--section", arguments.sections,
                 "Cut away what lies beyond x=M (before: -x=M; y, z; m; along a direction: NX,NY,NZ,M); "
                 "repeatable");
  command
      .option("--explode", arguments.style.explode,
              "Draw parts apart from each other, 0 to 1; nothing is felt meanwhile")
      .numberFrom(0.0, 1.0);
  command.option("--colour-by", arguments.colourBy, "Colour parts by body, material or owner");
  command.flag("--ghosts", arguments.style.ghosts, "Draw what is hidden faintly");
}

}  // namespace

void addJoinOptions(assets::CommandLine& command, JoinArguments& arguments) {
  command.option("link", arguments.link, "Join link, as tandem-server prints it (tandem://...)").required();
  command.option("--name", arguments.name, "Your name, as the others see it [$USER, else the role]");
  command.option("--colour", arguments.colour, "Your colour, #RRGGBB [one that nobody else has]");
  command.flag("--headless", arguments.headless, "No window: a table in the terminal");
  command.option("--device", arguments.device,
                 "Device in your hand; see 'tandem devices' [stylus, moved by mouse and keyboard; "
                 "without a window: none]");
  command
      .option("--calibration", arguments.calibration,
              "Where the device's workspace lies in the scene (JSON of 'tandem devices --calibrate')")
      .needs("--device");
  command.option("--hand", arguments.hand, "Script of a simulated hand (JSON) instead of a device");
  command.option("--tool", arguments.tool,
                 "What your hands touch with: point, or ball:RADIUS_M [the tip that is drawn, a ball]");
  const assets::CommandLineOption second =
      command.option("--second-device", arguments.secondDevice,
                     "Device in your other hand: both hold parts together, the "
                     "same one or two, without the network between [none]");
  command
      .option("--second-calibration", arguments.secondCalibration, "As --calibration, of the second device")
      .needs(second);
  command.option("--second-hand", arguments.secondHand, "Script of a second hand [none]").excludes(second);
  command.option("--duration", arguments.duration, "Leave after this many seconds [stay]")
      .numberFrom(1e-3, 1e9);
  command.option("--screenshot", arguments.screenshot, "Write a picture (PNG) at the end");
  command
      .option("--clashes", arguments.clashes,
              "Open the list of clashes, and of parts that stand nearer than so many m to each other")
      .numberFrom(0.0, 1e6);
  command.option("--way-out", arguments.wayOut, "Find this part's way out of its assembly, and draw it");
  command.flag("--notes", arguments.notes, "Open the list of notes and views");
  command.flag("--measures", arguments.measures, "Open the panel of measures");
  addLooks(command, arguments);
  command.flag("--alone", arguments.alone, "Do not follow the sections and views that others share");
  command.option("--record", arguments.record, "Record the session for tandem replay, to a new file");
  command.option("--json", arguments.json, "Write what happened to this file");
  command.option("--trace", arguments.trace, "Write each pose of moving parts, as had here (CSV)");
  command.option("--cache", arguments.cache,
                 "Folder for scenes and their models [" + assets::defaultCacheDirectory() + "]");
  command.option("--max-scene", arguments.maxScene, "Largest scene to fetch, MiB")
      .integerFrom(1, 1 << 20)
      .showDefault();
  command.option("--width", arguments.width, "Of window and picture, pixels")
      .integerFrom(200, 7680)
      .showDefault();
  command.option("--height", arguments.height, "The same").integerFrom(200, 4320).showDefault();
  command
      .option("--deadband", arguments.deadband,
              "How wrong a moving part may look before its state is sent, as a share of its "
              "displacement (Weber fraction)")
      .numberFrom(0.0, 1.0)
      .showDefault();
  command.flag("--tcp", arguments.tcp, "State over TLS, not UDP (which falls back to TLS by itself)");
  command.flag("--facets", arguments.facets, "Feel flat facets where normals say that a surface is curved");
  command.flag("--no-part-contact", arguments.noPartContact,
               "A part in the hand passes through others, which costs less of every tick");
  command.flag("--quiet", arguments.quiet, "Print nothing but errors");
}

}  // namespace tandem::client
