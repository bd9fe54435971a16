#pragma once

#include <atomic>

#include "core/base/clock.h"

namespace camrig {

/// Adds the CPU time that its thread takes while it lives.
class CpuMeter {
public:
    explicit CpuMeter(std::atomic<TimeNs>& sum_ns) : sum_ns_(sum_ns), start_ns_(thread_cpu_ns()) {}
    ~CpuMeter() { sum_ns_ += thread_cpu_ns() - start_ns_; }
    CpuMeter(const CpuMeter&) = delete;
    CpuMeter& operator=(const CpuMeter&) = delete;

private:
    std::atomic<TimeNs>& sum_ns_;
    TimeNs start_ns_;
};

}  // namespace camrig
