#include "control/onvif/event_topic.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "control/onvif/authentication.h"

namespace camrig::onvif {
namespace {

constexpr std::size_t max_expression = 1024;

struct TopicRow {
    std::string_view path;  ///< below tns1:
    std::string_view source, data;
    /// Of a topic of the rule engine, whose messages name an analysis and its rule.
    std::string_view rule = {};
};

/// By EventTopic; of one parent, one after the other.
constexpr std::array<TopicRow, event_topic_count> topic_rows{{
    {"VideoSource/MotionAlarm", "Source", "State"},
    {"VideoSource/GlobalSceneChange/ImagingService", "Source", "State"},
    {"VideoSource/ImageTooBlurry/ImagingService", "Source", "State"},
    {"VideoSource/ImageTooBright/ImagingService", "Source", "State"},
    {"VideoSource/ImageTooDark/ImagingService", "Source", "State"},
    {"RuleEngine/CellMotionDetector/Motion", "VideoSourceConfigurationToken", "IsMotion", "motion"},
    {"RuleEngine/TamperDetector/Tamper", "VideoSourceConfigurationToken", "IsTamper", "tamper"},
    {"Device/Trigger/DigitalInput", "InputToken", "LogicalState"},
}};

const TopicRow& row_of(EventTopic topic) {
    return topic_rows[static_cast<std::size_t>(topic)];
}

std::vector<std::string_view> split(std::string_view text, char mark) {
    std::vector<std::string_view> parts;
    for (;;) {
        const std::size_t at = text.find(mark);
        parts.push_back(text.substr(0, at));
        if (at == std::string_view::npos) return parts;
        text.remove_prefix(at + 1);
    }
}

std::string item(std::string_view name, std::string_view value) {
    return element("tt:SimpleItem", "", "Name=\"" + std::string(name) + "\" Value=\"" + escaped(value) + "\"");
}

std::string described(std::string_view name, std::string_view type) {
    return element("tt:SimpleItemDescription", "",
                   "Name=\"" + std::string(name) + "\" Type=\"" + std::string(type) + "\"");
}

std::string description(const TopicRow& row) {
    std::string source = described(row.source, "tt:ReferenceToken");
    if (!row.rule.empty())
        source += described("VideoAnalyticsConfigurationToken", "tt:ReferenceToken") + described("Rule", "xs:string");
    return element("tt:MessageDescription",
                   element("tt:Source", source) + element("tt:Data", described(row.data, "xs:boolean")),
                   "IsProperty=\"true\"");
}

/// Whether a path of an expression, as "tns1:VideoSource//." or "tns1:VideoSource/MotionAlarm", means the topic. Its
/// prefixes are of no account, as all topics are of one namespace.
bool fits(std::string_view expression, std::string_view path) {
    const bool is_subtree = expression.ends_with("//.");
    if (is_subtree) expression.remove_suffix(3);
    const auto wanted = split(expression, '/'), parts = split(path, '/');
    if (is_subtree ? wanted.size() > parts.size() : wanted.size() != parts.size()) return false;
    return std::ranges::equal(wanted, std::span(parts).first(wanted.size()),
                              [](std::string_view pattern, std::string_view part) {
                                  pattern = pattern.substr(pattern.find(':') + 1);  // npos + 1 is 0
                                  return pattern == "*" || pattern == part;
                              });
}

}  // namespace

EventTopics picture_topics() {
    return EventTopics().set().reset(static_cast<std::size_t>(EventTopic::digital_input));
}

std::string notification(const EventMessage& message) {
    const TopicRow& row = row_of(message.property.topic);
    std::string source = item(row.source, message.property.source);
    if (!row.rule.empty())
        source += item("VideoAnalyticsConfigurationToken", message.property.source) + item("Rule", row.rule);
    static constexpr std::string_view kinds[] = {"Initialized", "Changed", "Deleted"};
    const std::string head = "UtcTime=\"" + text_of_time(message.utc_ns) + "\" PropertyOperation=\"" +
                             std::string(kinds[static_cast<std::size_t>(message.kind)]) + "\"";
    const std::string data = item(row.data, message.state ? "true" : "false");
    return element("wsnt:NotificationMessage",
                   element("wsnt:Topic", "tns1:" + std::string(row.path),
                           R"(Dialect="http://www.onvif.org/ver10/tev/topicExpression/ConcreteSet")") +
                       element("wsnt:Message",
                               element("tt:Message", element("tt:Source", source) + element("tt:Data", data), head)));
}

std::string topic_set() {
    std::string text;
    std::vector<std::string_view> open;
    const auto name = [&](std::size_t depth) { return (depth == 0 ? "tns1:" : "") + std::string(open[depth]); };
    const auto close_to = [&](std::size_t depth) {
        for (; open.size() > depth; open.pop_back()) text += "</" + name(open.size() - 1) + ">";
    };
    for (const TopicRow& row : topic_rows) {
        const auto parts = split(row.path, '/');
        close_to(static_cast<std::size_t>(std::ranges::mismatch(open, parts).in1 - open.begin()));
        while (open.size() < parts.size()) {
            open.push_back(parts[open.size()]);
            text += "<" + name(open.size() - 1) + (open.size() == parts.size() ? R"( wstop:topic="true">)" : ">");
        }
        text += description(row);
    }
    close_to(0);
    return element("wstop:TopicSet", text);
}

Answered<EventTopics> read_filter(XmlElement filter) {
    const auto refuse = [](std::string_view fault, std::string why) {
        return std::unexpected(Fault{true, fault, {}, std::move(why)});
    };
    if (filter.child("MessageContent"))
        return refuse("wsnt:InvalidFilterFault", "messages are filtered by their topics only");
    const XmlElement expression = filter.child("TopicExpression");
    if (!expression) return EventTopics().set();
    const std::string_view dialect = expression.attribute("Dialect").value_or("");
    if (!dialect.empty() && dialect != "http://www.onvif.org/ver10/tev/topicExpression/ConcreteSet" &&
        dialect != "http://docs.oasis-open.org/wsn/t-1/TopicExpression/Concrete")
        return refuse("wsnt:TopicExpressionDialectUnknownFault", "this dialect of topic expressions is not known");
    const std::string_view text = expression.text();
    if (text.size() > max_expression)
        return refuse("wsnt:InvalidTopicExpressionFault", "a topic expression is at most 1024 bytes");
    EventTopics topics;
    for (const std::string_view one : split(text, '|'))
        for (std::size_t i = 0; i < topic_rows.size(); ++i)
            if (fits(trimmed(one), topic_rows[i].path)) topics.set(i);
    if (topics.none()) return refuse("wsnt:TopicNotSupportedFault", "none of the topics that are told of is named");
    return topics;
}

}  // namespace camrig::onvif
