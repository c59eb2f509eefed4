#include "haptics/body/control_dynamics.h"

#include <algorithm>
#include <cmath>

#include "assets/base/constants.h"

namespace tandem::haptics {
namespace {

/// The detent well nearest to a value.
struct Well {
  double offset = 0.0;  // of the value from the well
  double width = 0.0;   // 0 = there is no well
};

double widthIn(const assets::Detents& detents, double gap) {
  return detents.width > 0.0 ? std::min(detents.width, gap) : gap;
}

/// Distance from the last detent of an endless dial to the first one, one turn on; 0 for other controls.
double closingGap(const assets::Control& control) {
  const std::vector<double>& places = control.detents.places;
  if (!control.endless || places.empty()) return 0.0;
  return control.max - control.min - (places.back() - places.front());
}

/// The well of a value beyond the first or last detent; end wells are as wide outside as inside.
Well endWell(const assets::Detents& detents, double closing, double value, bool last) {
  const std::vector<double>& places = detents.places;
  const std::size_t n = places.size();
  if (closing > 0.0) {
    double offset = value - (last ? places.back() : places.front());
    if (std::abs(offset) > 0.5 * closing) offset += last ? -closing : closing;
    return {offset, widthIn(detents, closing)};
  }
  const double width =
      n == 1 ? detents.width : widthIn(detents, last ? places[n - 1] - places[n - 2] : places[1] - places[0]);
  return {value - (last ? places.back() : places.front()), width};
}

/// `closing` is that of closingGap().
Well nearestWell(const assets::Detents& detents, double closing, double value) {
  const std::vector<double>& places = detents.places;
  if (places.empty() || detents.force == 0.0) return {};
  const auto above = std::upper_bound(places.begin(), places.end(), value);
  if (above == places.begin()) return endWell(detents, closing, value, false);
  if (above == places.end()) return endWell(detents, closing, value, true);
  const double low = *(above - 1), high = *above;
  return {value - low < high - value ? value - low : value - high, widthIn(detents, high - low)};
}

double resistanceOf(const assets::Detents& detents, const Well& well) {
  return std::abs(well.offset) < 0.5 * well.width
             ? detents.force * std::sin(2.0 * kPi * well.offset / well.width)
             : 0.0;
}

double steepestOf(const assets::Detents& detents, double closing) {
  const std::vector<double>& places = detents.places;
  if (places.empty() || !(detents.force > 0.0)) return 0.0;
  double narrowest = places.size() == 1 && !(closing > 0.0) ? detents.width : 1e300;
  for (std::size_t i = 1; i < places.size(); ++i)
    narrowest = std::min(narrowest, widthIn(detents, places[i] - places[i - 1]));
  if (closing > 0.0) narrowest = std::min(narrowest, widthIn(detents, closing));
  return 2.0 * kPi * detents.force / narrowest;
}

double wrapped(const assets::Control& control, double value) {
  return control.endless ? std::remainder(value, 2.0 * kPi) : value;
}

}  // namespace

double resistance(const assets::Control& control, double value) {
  const double q = wrapped(control, value);
  double force = control.springStiffness * (q - control.springRest);
  force += resistanceOf(control.detents, nearestWell(control.detents, closingGap(control), q));
  const assets::Click& click = control.click;
  if (const double x = q - click.at; click.drop > 0.0 && std::abs(x) < click.width)
    force += 0.5 * click.drop * (1.0 + std::cos(kPi * x / click.width));
  return force;
}

double storedEnergy(const assets::Control& control, double value) {
  const auto absolute = [&](double q) {
    const double x = q - control.springRest;
    double energy = 0.5 * control.springStiffness * x * x;
    if (const Well well = nearestWell(control.detents, closingGap(control), q); well.width > 0.0) {
      const double s = std::min(std::abs(well.offset), 0.5 * well.width);
      energy +=
          control.detents.force * well.width / (2.0 * kPi) * (1.0 - std::cos(2.0 * kPi * s / well.width));
    }
    const assets::Click& click = control.click;
    if (click.drop > 0.0) {
      const double y = std::clamp(q - click.at, -click.width, click.width);
      energy += 0.5 * click.drop * (y + click.width + click.width / kPi * std::sin(kPi * y / click.width));
    }
    return energy;
  };
  return absolute(wrapped(control, value)) - absolute(control.min);
}

double steepestResistance(const assets::Control& control) {
  double steepest = steepestOf(control.detents, closingGap(control));
  if (control.click.drop > 0.0) steepest += 0.5 * kPi * control.click.drop / control.click.width;
  return steepest;
}

double detentResistance(const assets::Detents& detents, double value) {
  return resistanceOf(detents, nearestWell(detents, 0.0, value));
}

double steepestDetent(const assets::Detents& detents) { return steepestOf(detents, 0.0); }

void stepControl(const assets::Control& control, double steepest, const AxisLoad& load, double dt,
                 ControlState& state) {
  const ControlState before = state;
  const double step = dt / kControlSubsteps;
  const double curvature = steepest + control.springStiffness + load.stiffness;
  const double effective =
      control.inertia + step * (control.damping + load.damping) + step * step * curvature;
  double displacement = 0.0;
  for (int i = 0; i < kControlSubsteps; ++i) {
    const double push = load.force + load.damping * before.rate - load.stiffness * displacement;
    const double momentum = control.inertia * state.rate + step * (push - resistance(control, state.value));
    const double slowed =
        std::copysign(std::max(0.0, std::abs(momentum) - step * control.friction), momentum);
    state.rate = slowed / effective;
    const double wanted = state.value + step * state.rate;
    const double from = state.value;
    state.value = assets::admissible(control, wanted);
    if (control.endless) {
      displacement += step * state.rate;
    } else {
      displacement += state.value - from;
      if (state.value != wanted) state.rate = 0.0;
    }
  }
}

GuidedRate guidedRate(const assets::Control& control, double steepest, const AxisLoad& load, double dt,
                      const ControlState& state) {
  const double curvature = steepest + control.springStiffness + load.stiffness;
  const double inertia = control.inertia + dt * (control.damping + load.damping) + dt * dt * curvature;
  const double push = load.force + load.damping * state.rate - resistance(control, state.value);
  return {(control.inertia * state.rate + dt * push) / inertia, inertia};
}

}  // namespace tandem::haptics
