// The void fraction on the fine grid at the ends of the coupling interval, and how it runs between them.
//
// With s_n = (eps^n - eps^{n-1})/D_n, D_n the length of interval n, the slope at t^n is that of the parabola through
// three couplings (BDF2), s_n + (s_n - s_{n-1}) D_n/(D_n + D_{n-1}); the slope at an interval's begin is the one with
// which the last interval ended, so that d(eps)/dt is continuous. Volume of particles that were inserted or deleted
// changes eps at once at an interval's begin, and is no part of d(eps)/dt.
#pragma once

#include "cfd/grid/field.h"
#include "cfd/grid/void_fraction.h"
#include "coupling/coupling_state.h"
#include "coupling/settings.h"

namespace twogrid {

class VoidHistory {
 public:
  /// box: of the fluid's fields. Works on `state`.
  VoidHistory(VoidHistoryState& state, const Box& box, Interpolate interpolate);

  /// eps at the end of the interval to come: to be filled, halo included, before begin().
  CellField<FineGrid>& next() { return next_; }
  const CellField<FineGrid>& now() const { return state_.now; }
  /// eps never changed before now.
  void start();
  /// Sets up an interval that leads from now() to next(). replaced: what is added to now() before, may be null.
  VoidFractionInTime begin(double interval, const CellField<FineGrid>* replaced);
  /// The interval is over: next() becomes now().
  void commit();

  /// Weight r of the extrapolation x_n + r (x_n - x_{n-1}) of interval means to the interval's end, as used for eps.
  double extrapolation(double interval) const {
    return interpolate_ == Interpolate::kSmooth && state_.interval > 0 ? interval / (interval + state_.interval) : 0.0;
  }

 private:
  VoidFractionInTime path() const;

  VoidHistoryState& state_;
  Interpolate interpolate_;
  CellField<FineGrid> next_;
  double interval_ = 0;  // to next() (s)
};

}  // namespace twogrid
