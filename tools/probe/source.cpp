#include "tools/probe/source.h"

namespace camrig::probe {

Result<std::unique_ptr<Source>> open_source(const std::string& address, const SourceOptions& options) {
    if (address.starts_with("http://")) return open_http_source(address, options);
    if (address.starts_with("rtsp://") || address.starts_with("rtsps://")) return open_rtsp_source(address, options);
    if (address.find("://") != std::string::npos)
        return error(ErrorKind::unsupported, "give a /dev/videoN, an http:// or an rtsp:// address");
    return open_device_source(address, options);
}

}  // namespace camrig::probe
