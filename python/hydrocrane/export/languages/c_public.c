static int not_finite(const double *numbers, int count)
{
    int found = 0;
    for (int i = 0; i < count; i++)
        found |= !(numbers[i] * 0.0 == 0.0);
    return found;
}

int hydrocrane_derivative(const double *x, const double *u, const double *p, double *dx)
{
    PREPARE
    derivative(x, u, c, dx);
    return not_finite(dx, HYDROCRANE_STATES);
}

int hydrocrane_outputs(const double *x, const double *u, const double *p, double *y)
{
    PREPARE
    outputs(x, u, c, y);
    return not_finite(y, HYDROCRANE_OUTPUTS);
}

/* ---- */
int hydrocrane_sparse(const double *x, const double *u, const double *p, double *dx, double *values)
{
    PREPARE
    linearised(x, u, c, dx, values);
    return not_finite(dx, HYDROCRANE_STATES) | not_finite(values, HYDROCRANE_NONZEROS);
}

int hydrocrane_linearise(const double *x, const double *u, const double *p, double *dx, double *dfdx)
{
    double values[HYDROCRANE_NONZEROS];
    const int fault = hydrocrane_sparse(x, u, p, dx, values);
    memset(dfdx, 0, HYDROCRANE_STATES * HYDROCRANE_STATES * sizeof *dfdx);
    for (int k = 0; k < HYDROCRANE_NONZEROS; k++)
        dfdx[in_dense[k]] = values[k];
    return fault;
}

