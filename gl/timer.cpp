// SPDX-License-Identifier: MPL-2.0
#include "gl/timer.h"

#include <glad/gl.h>

namespace isocast::gl {

Timer::Timer() {
    unsigned ids[2];
    glCreateQueries(GL_TIMESTAMP, 2, ids);
    begin_ = Handle<delete_query>(ids[0]);
    end_ = Handle<delete_query>(ids[1]);
}

void Timer::start() {
    glQueryCounter(begin_.id(), GL_TIMESTAMP);
}
void Timer::stop() {
    glQueryCounter(end_.id(), GL_TIMESTAMP);
}

double Timer::milliseconds() const {
    GLuint64 begin = 0;
    GLuint64 end = 0;
    glGetQueryObjectui64v(begin_.id(), GL_QUERY_RESULT, &begin);
    glGetQueryObjectui64v(end_.id(), GL_QUERY_RESULT, &end);
    return static_cast<double>(end - begin) * 1e-6; // ns -> ms
}

} // namespace isocast::gl
