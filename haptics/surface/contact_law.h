#pragma once

// How force follows depth: elastic, viscoelastic, plastic. One-dimensional; N, m, s.

namespace tandem::haptics {

/// What a viscoelastic contact remembers.
struct ViscoelasticMemory {
  double depth = 0.0;  // m, of the surface itself, which may lag behind a tool that withdraws
  double arm = 0.0;    // N, of the spring that relaxes
};

/// Force of the standard linear solid: a spring k beside a spring k2 in series with a dashpot, q' = k2 d' - q
/// / tau, F = k d + q (Fung, "Biomechanics", 2.11). Exact for a depth that changes linearly within the tick.
/// The surface only pushes: where the tool withdraws faster than it recovers, it recovers alone (F = 0) with
/// tau (1 + k2 / k), and is felt again where it then is. Passive: what is stored in k and k2 came from the
/// tool.
double viscoelasticForce(double k, double k2, double tau, double depth, double dt,
                         ViscoelasticMemory& memory);

/// Force of an elastic-plastic contact with linear isotropic hardening at a place whose permanent set is
/// `set` m: F = k (d - set) as long as F <= yield + hardening * set; beyond, the set grows until that holds
/// (return mapping, Simo & Hughes, "Computational Inelasticity", box 1.4; exact, rate-independent). Raises
/// `set`, never lowers it.
double plasticForce(double k, double yield, double hardening, double depth, double& set);

}  // namespace tandem::haptics
