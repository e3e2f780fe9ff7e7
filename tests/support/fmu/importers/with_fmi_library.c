/* Importer with FMI Library 3.0: read an unpacked FMU, take ten steps, print all messages.
 *
 *     with_fmi_library FOLDER    (an absolute path) */
#include <fmilib.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static int messages; /* of the library */

static void print_message(jm_callbacks *callbacks, jm_string module, jm_log_level_enu_t level, jm_string text)
{
    (void)callbacks, messages++;
    printf("%s: %s: %s\n", jm_log_level_to_string(level), module, text);
}

static void log_2(void *environment, fmi2_string_t name, fmi2_status_t status, fmi2_string_t category,
                  fmi2_string_t text, ...)
{
    va_list rest;
    va_start(rest, text);
    (void)environment, (void)status;
    printf("%s: %s: ", name, category), vprintf(text, rest), putchar('\n');
    va_end(rest);
}

static void log_3(fmi3_instance_environment_t environment, fmi3_status_t status, fmi3_string_t category,
                  fmi3_string_t text)
{
    (void)environment, (void)status;
    printf("%s: %s\n", category, text);
}

static int fail(const char *call) { return printf("failed: %s\n", call), 1; }

static int run_2(fmi_import_context_t *context, const char *folder)
{
    static fmi2_callback_functions_t callbacks = {log_2, calloc, free, NULL, NULL};
    fmi2_import_t *fmu = fmi2_import_parse_xml(context, folder, NULL);
    if (!fmu) return fail("read");
    const double step = fmi2_import_get_default_experiment_step(fmu);
    if (fmi2_import_create_dllfmu(fmu, fmi2_fmu_kind_cs, &callbacks)) return fail("load");
    if (fmi2_import_instantiate(fmu, "checked", fmi2_cosimulation, NULL, 0)) return fail("instantiate");
    if (fmi2_import_setup_experiment(fmu, 0, 0.0, 0.0, 0, 0.0)) return fail("set up");
    if (fmi2_import_enter_initialization_mode(fmu) || fmi2_import_exit_initialization_mode(fmu))
        return fail("initialize");
    for (int k = 0; k < 10; k++)
        if (fmi2_import_do_step(fmu, k * step, step, 1)) return fail("step");
    fmi2_import_terminate(fmu), fmi2_import_free_instance(fmu);
    fmi2_import_destroy_dllfmu(fmu), fmi2_import_free(fmu);
    return 0;
}

static int run_3(fmi_import_context_t *context, const char *folder)
{
    fmi3_import_t *fmu = fmi3_import_parse_xml(context, folder, NULL);
    if (!fmu) return fail("read");
    const double step = fmi3_import_get_default_experiment_step_size(fmu);
    fmi3_boolean_t event, terminate, early;
    double reached;
    if (fmi3_import_create_dllfmu(fmu, fmi3_fmu_kind_cs, NULL, log_3)) return fail("load");
    if (fmi3_import_instantiate_co_simulation(fmu, "checked", NULL, 0, 0, 0, 0, NULL, 0, NULL))
        return fail("instantiate");
    if (fmi3_import_enter_initialization_mode(fmu, 0, 0.0, 0.0, 0, 0.0) ||
        fmi3_import_exit_initialization_mode(fmu))
        return fail("initialize");
    for (int k = 0; k < 10; k++)
        if (fmi3_import_do_step(fmu, k * step, step, 1, &event, &terminate, &early, &reached))
            return fail("step");
    fmi3_import_terminate(fmu), fmi3_import_free_instance(fmu);
    fmi3_import_destroy_dllfmu(fmu), fmi3_import_free(fmu);
    return 0;
}

int main(int count, char **arguments)
{
    jm_callbacks callbacks = {malloc, calloc, realloc, free, print_message, jm_log_level_warning, NULL, ""};
    fmi_import_context_t *context = fmi_import_allocate_context(&callbacks);
    if (count < 2 || !context) return fail("usage: with_fmi_library FOLDER");
    const fmi_version_enu_t version = fmi_import_get_fmi_version(context, NULL, arguments[1]);
    const int failed = version == fmi_version_2_0_enu   ? run_2(context, arguments[1])
                       : version == fmi_version_3_0_enu ? run_3(context, arguments[1])
                                                        : fail("version");
    fmi_import_free_context(context);
    printf("FMI Library: %d messages\n", messages);
    return failed || messages;
}
