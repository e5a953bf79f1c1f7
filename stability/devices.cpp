// SPDX-License-Identifier: MPL-2.0
#include "stability/devices.h"

#include <algorithm>

namespace isocast::stability {

Devices::~Devices() {
    // Objects are deleted in the context that has them.
    for (auto& [backend, device] : devices_) {
        device->context->make_current();
        device.reset();
    }
}

Device& Devices::at(gl::Backend backend) {
    if (const auto missing = missing_.find(backend); missing != missing_.end())
        throw Skip(missing->second);
    std::unique_ptr<Device>& device = devices_[backend];
    try {
        if (!device) device = std::make_unique<Device>(backend, shader_folder_);
    } catch (const gl::NoContextError& error) {
        devices_.erase(backend);
        std::string reason = error.what();
        std::ranges::replace(reason, '\n', ' ');
        missing_[backend] = reason;
        throw Skip(reason);
    }
    device->context->make_current();
    return *device;
}

std::vector<gl::DriverInfo> Devices::drivers() const {
    std::vector<gl::DriverInfo> drivers;
    for (const auto& [backend, device] : devices_) drivers.push_back(device->context->driver());
    return drivers;
}

} // namespace isocast::stability
