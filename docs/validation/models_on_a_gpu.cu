// Many cranes on the device, stepped and timed: what models_on_a_gpu.py compiles and calls. `crane.cu` is the exported model.
#include "crane.cu"
#include <cuda_runtime.h>

static const int BLOCK = 64;
static int cranes;
static double *states, *spools, *rates, *values;

// Classical Runge-Kutta over `count` steps of `h` with held spools, a thread for each crane.
__global__ void runge_kutta(int cranes, int count, double h, double *x, const double *u)
{
    const double look[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    const int k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= cranes)
        return;
    double own[HYDROCRANE_STATES], at[HYDROCRANE_STATES], slope[HYDROCRANE_STATES], sum[HYDROCRANE_STATES];
    double held[HYDROCRANE_INPUTS];
    for (int i = 0; i < HYDROCRANE_STATES; i++)
        own[i] = x[(size_t)i * cranes + k];
    for (int i = 0; i < HYDROCRANE_INPUTS; i++)
        held[i] = u[(size_t)i * cranes + k];
    for (int step = 0; step < count; step++) {
        for (int i = 0; i < HYDROCRANE_STATES; i++)
            sum[i] = slope[i] = 0.0;
#pragma unroll 1
        for (int stage = 0; stage < 4; stage++) {
            for (int i = 0; i < HYDROCRANE_STATES; i++)
                at[i] = own[i] + look[stage] * h * slope[i];
            derivative(at, held, 0, slope);
            for (int i = 0; i < HYDROCRANE_STATES; i++)
                sum[i] += weight[stage] * slope[i];
        }
        for (int i = 0; i < HYDROCRANE_STATES; i++)
            own[i] += h / 6.0 * sum[i];
    }
    for (int i = 0; i < HYDROCRANE_STATES; i++)
        x[(size_t)i * cranes + k] = own[i];
}

static size_t bytes(int rows) { return sizeof(double) * rows * (size_t)cranes; }

// Each returns a cudaError_t, 0 where all went well.
extern "C" int begin(int count, const double *x)
{
    cudaFree(states), cudaFree(spools), cudaFree(rates), cudaFree(values);
    cranes = count;
    cudaMalloc(&states, bytes(HYDROCRANE_STATES));
    cudaMalloc(&spools, bytes(HYDROCRANE_INPUTS));
    cudaMalloc(&rates, bytes(HYDROCRANE_STATES));
    cudaMalloc(&values, bytes(HYDROCRANE_NONZEROS));
    cudaMemcpy(states, x, bytes(HYDROCRANE_STATES), cudaMemcpyHostToDevice);
    return cudaGetLastError();
}

extern "C" int step(int count, double h, const double *u)
{
    cudaMemcpy(spools, u, bytes(HYDROCRANE_INPUTS), cudaMemcpyHostToDevice);
    runge_kutta<<<(cranes + BLOCK - 1) / BLOCK, BLOCK>>>(cranes, count, h, states, spools);
    const int launched = cudaGetLastError(), ran = cudaDeviceSynchronize();
    return launched ? launched : ran;
}

// Derivatives and all partial derivatives that are not zero, at the states.
extern "C" int evaluate(const double *u)
{
    cudaMemcpy(spools, u, bytes(HYDROCRANE_INPUTS), cudaMemcpyHostToDevice);
    hydrocrane_sparse_many<<<(cranes + BLOCK - 1) / BLOCK, BLOCK>>>(cranes, 1, states, spools, 0, rates, values);
    const int launched = cudaGetLastError(), ran = cudaDeviceSynchronize();
    return launched ? launched : ran;
}

extern "C" int read(double *x, double *dx, double *nonzeros)
{
    cudaMemcpy(x, states, bytes(HYDROCRANE_STATES), cudaMemcpyDeviceToHost);
    cudaMemcpy(dx, rates, bytes(HYDROCRANE_STATES), cudaMemcpyDeviceToHost);
    cudaMemcpy(nonzeros, values, bytes(HYDROCRANE_NONZEROS), cudaMemcpyDeviceToHost);
    return cudaGetLastError();
}
