#include "assets/base/command_line.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <utility>

#include <CLI/CLI.hpp>

#include "assets/base/assert.h"

namespace tandem::assets {

CommandLineOption& CommandLineOption::required() {
  option_->required();
  return *this;
}

CommandLineOption& CommandLineOption::typeName(const std::string& name) {
  option_->type_name(name);
  return *this;
}

CommandLineOption& CommandLineOption::showDefault() {
  option_->capture_default_str();
  return *this;
}

CommandLineOption& CommandLineOption::oneValue() {
  option_->allow_extra_args(false);
  return *this;
}

CommandLineOption& CommandLineOption::values(int count) {
  option_->expected(count);
  return *this;
}

CommandLineOption& CommandLineOption::numberFrom(double min, double max) {
  ASSERT(min <= max);
  // CLI11's own check of a range lets nan through.
  option_->check([min, max](const std::string& text) -> std::string {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (!text.empty() && *end == '\0' && value >= min && value <= max) return "";
    char message[96];
    std::snprintf(message, sizeof message, "must be a number from %g to %g, not ", min, max);
    return message + text;
  });
  return *this;
}

CommandLineOption& CommandLineOption::integerFrom(int min, int max) {
  ASSERT(min <= max);
  option_->check(CLI::Range(min, max));
  return *this;
}

CommandLineOption& CommandLineOption::needs(const CommandLineOption& other) {
  option_->needs(other.option_);
  return *this;
}

CommandLineOption& CommandLineOption::needs(const std::string& other) {
  option_->needs(other);
  return *this;
}

CommandLineOption& CommandLineOption::excludes(const CommandLineOption& other) {
  option_->excludes(other.option_);
  return *this;
}

CommandLine::CommandLine(const std::string& description, const std::string& version)
    : root_(std::make_shared<CLI::App>(description)), app_(root_.get()) {
  app_->set_version_flag("--version", version);
}

CommandLine::CommandLine(std::shared_ptr<CLI::App> root, CLI::App* app) : root_(std::move(root)), app_(app) {}

CommandLine CommandLine::command(const std::string& name, const std::string& description) {
  app_->require_subcommand(1);
  return {root_, app_->add_subcommand(name, description)};
}

std::vector<std::string> CommandLine::commandNames() const {
  std::vector<std::string> names;
  for (const CLI::App* command : app_->get_subcommands(nullptr)) names.push_back(command->get_name());
  return names;
}

CommandLineOption CommandLine::option(const std::string& name, std::string& value, const std::string& help) {
  return CommandLineOption(app_->add_option(name, value, help));
}

CommandLineOption CommandLine::option(const std::string& name, int& value, const std::string& help) {
  return CommandLineOption(app_->add_option(name, value, help));
}

CommandLineOption CommandLine::option(const std::string& name, double& value, const std::string& help) {
  return CommandLineOption(app_->add_option(name, value, help));
}

CommandLineOption CommandLine::option(const std::string& name, std::int64_t& value, const std::string& help) {
  return CommandLineOption(app_->add_option(name, value, help));
}

CommandLineOption CommandLine::option(const std::string& name, std::uint64_t& value,
                                      const std::string& help) {
  return CommandLineOption(app_->add_option(name, value, help));
}

CommandLineOption CommandLine::option(const std::string& name, std::vector<std::string>& value,
                                      const std::string& help) {
  return CommandLineOption(app_->add_option(name, value, help));
}

CommandLineOption CommandLine::flag(const std::string& name, bool& value, const std::string& help) {
  return CommandLineOption(app_->add_flag(name, value, help));
}

void CommandLine::footer(const std::string& text) { app_->footer(text); }

void CommandLine::onRun(std::function<void()> run) { app_->callback(std::move(run)); }

std::optional<int> CommandLine::parse(const std::string& program, int argc, char** argv) {
  ASSERT(app_ == root_.get());
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app_->exit(success);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "%s: %s (see --help)\n", program.c_str(), error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), error.what());
    return 1;
  }
  return std::nullopt;
}

}  // namespace tandem::assets
