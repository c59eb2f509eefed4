// tandem: one site of a session, and the tools beside it.

#include <csignal>
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "client/commands/command.h"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its limit is a failed write, like a full disk
  CLI::App app{
      "Tandem: several people, each at their own site, put their hands on one CAD scene and feel it."};
  app.set_version_flag("--version", TANDEM_VERSION);
  app.require_subcommand(1);
  app.footer(
      "A first session:\n"
      "  tandem-server assets/scenes/pump.glb     prints one join link a role\n"
      "  tandem join LINK                         in another terminal, for each person\n"
      "Every command explains itself: tandem COMMAND --help");
  int exitCode = tandem::client::kExitDone;
  tandem::client::addJoin(app, exitCode);
  tandem::client::addCheck(app, exitCode);
  tandem::client::addProbe(app, exitCode);
  tandem::client::addSimulate(app, exitCode);
  tandem::client::addDevices(app, exitCode);
  tandem::client::addReplay(app, exitCode);
  tandem::client::addReport(app, exitCode);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "tandem: %s (see --help)\n", error.what());
    return tandem::client::kExitBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", error.what());
    return tandem::client::kExitFailed;
  }
  return exitCode;
}
