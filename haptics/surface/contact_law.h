#pragma once

// Contact laws: force as a function of depth, elastic, viscoelastic or plastic. One-dimensional; N, m, s.

namespace tandem::haptics {

/// Persistent state of a viscoelastic contact.
struct ViscoelasticMemory {
  double depth = 0.0;  // m, of the surface itself, which may lag behind a retreating tool
  double arm = 0.0;    // N, of the relaxing spring
};

/// Force of the standard linear solid: a spring k beside a spring k2 in series with a dashpot, q' = k2 d' - q
/// / tau, F = k d + q (Fung, "Biomechanics", 2.11). Exact for a depth that changes linearly within the tick.
/// The surface only pushes: where the tool retreats faster than the surface recovers, the surface recovers
/// alone (F = 0) with tau (1 + k2 / k), and the tool meets it again where it then is. Passive: all energy
/// stored in k and k2 came from the tool.
double viscoelasticForce(double k, double k2, double tau, double depth, double dt,
                         ViscoelasticMemory& memory);

/// Force of an elastic-plastic contact with linear isotropic hardening at a place with the permanent set
/// `set` m. F = k (d - set) as long as F <= yield + hardening * set; beyond, the set grows until that holds
/// (return mapping, Simo & Hughes, "Computational Inelasticity", box 1.4; exact, rate-independent). Never
/// lowers `set`.
double plasticForce(double k, double yield, double hardening, double depth, double& set);

}  // namespace tandem::haptics
