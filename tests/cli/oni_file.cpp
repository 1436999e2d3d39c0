#include "oni_file.h"

#include <cstdint>
#include <cstring>

namespace handhold::test {
namespace {

constexpr std::uint32_t kNode = 1;
enum Record : std::uint32_t {
  kIntProperty = 3,
  kGeneralProperty = 6,
  kDataBegin = 8,
  kStateReady = 9,
  kNewData = 10,
  kEnd = 11,
  kNodeAdded = 13
};

/// Values one after the other, without gaps; little-endian, as all machines that OpenNI2 runs on.
class Bytes {
 public:
  template <class T>
  Bytes& add(T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    text_.append(raw, sizeof raw);
    return *this;
  }
  Bytes& add_text(const std::string& text) {
    add(static_cast<std::uint32_t>(text.size() + 1));
    text_.append(text.c_str(), text.size() + 1);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// `fields` belong to the header, `payload` follows it.
std::string record(Record type, const std::string& fields, const std::string& payload = "") {
  constexpr std::uint32_t kHeaderBytes = 28;
  Bytes bytes;
  bytes.add<std::uint32_t>('N' | 'I' << 8 | 'R' << 16).add<std::uint32_t>(type).add(kNode);
  bytes.add(static_cast<std::uint32_t>(kHeaderBytes + fields.size()));
  bytes.add(static_cast<std::uint32_t>(payload.size()));
  bytes.add<std::uint64_t>(0);  // the record that this one replaces
  return bytes.text() + fields + payload;
}

std::string property(Record type, const std::string& name, const Bytes& value) {
  Bytes fields;
  fields.add_text(name).add(static_cast<std::uint32_t>(value.text().size()));
  return record(type, fields.text() + value.text());
}

std::string int_property(const std::string& name, std::uint64_t value) {
  return property(kIntProperty, name, Bytes().add(value));
}

std::uint64_t time_us(std::size_t frame) {
  return 33'333 * frame;
}

std::string node(const OniRecording& recording, std::uint32_t frames) {
  const DepthImage& first = recording.frames.front();
  Bytes added, size, fov, cropping;
  added.add_text(recording.depth ? "Depth" : "IR").add<std::uint32_t>(recording.depth ? 2 : 5);
  added.add<std::uint32_t>('N' | 'O' << 8 | 'N' << 16 | 'E' << 24);  // no compression
  added.add(frames).add<std::uint64_t>(0).add(time_us(frames)).add<std::uint64_t>(0);
  size.add<std::uint32_t>(static_cast<std::uint32_t>(first.width));
  size.add<std::uint32_t>(static_cast<std::uint32_t>(first.height)).add<std::uint32_t>(30);
  fov.add(recording.h_fov).add(recording.v_fov);
  cropping.add<std::uint32_t>(0).add<std::uint64_t>(0);  // none: no offset, no size
  const std::uint64_t format = recording.tenths ? 101 : 100;
  return record(kNodeAdded, added.text()) + property(kGeneralProperty, "xnMapOutputMode", size) +
         int_property("oniPixelFormat", format) + int_property("xnMirror", recording.mirrored) +
         (recording.h_fov > 0 ? property(kGeneralProperty, "xnFOV", fov) : std::string()) +
         property(kGeneralProperty, "xnCropping", cropping) + record(kStateReady, "");
}

}  // namespace

std::string oni_file(const OniRecording& recording) {
  const std::size_t announced = recording.announced ? recording.announced : recording.frames.size();
  const auto frames = static_cast<std::uint32_t>(announced);
  Bytes header;
  header.add('N').add('I').add('1').add('0');
  header.add<std::uint8_t>(1).add<std::uint8_t>(0).add<std::uint16_t>(1).add<std::uint32_t>(0);  // version 1.0.1.0
  header.add(time_us(frames)).add(kNode);
  std::string file = header.text() + node(recording, frames);
  file += record(kDataBegin, Bytes().add(frames).add(time_us(frames)).text());
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    std::string payload;
    for (const std::uint16_t value : recording.frames[i].values) payload += Bytes().add(value).text();
    const Bytes fields = Bytes().add(time_us(i + 1)).add(static_cast<std::uint32_t>(i + 1));
    file += record(kNewData, fields.text(), payload);
  }
  return file + record(kEnd, "");
}

}  // namespace handhold::test
